// SPDX-License-Identifier: Apache-2.0
// Least squares over boxes of a regular grid: the positions along an axis are uncorrelated with
// those along the others, so that every slope is a quotient of its own, and a box that grows adds
// the sums of what it grew by.
#include "fit/even_boxes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "data/lattice/box_values.h"
#include "ovoid/error.h"

namespace ovoid::fit {
namespace {

using Size = std::array<std::int32_t, 3>;

double count_of(const Size& size) {
  return static_cast<double>(size[0]) * static_cast<double>(size[1]) * static_cast<double>(size[2]);
}

// Sums over a box, positions counted from its first sample, values in steps above the least.
struct BoxSums {
  double value = 0;
  std::array<double, 3> position_value{};

  void add(double steps, std::int64_t i, std::int64_t j, std::int64_t k) {
    value += steps;
    position_value[0] += steps * static_cast<double>(i);
    position_value[1] += steps * static_cast<double>(j);
    position_value[2] += steps * static_cast<double>(k);
  }
};

// The least squares' numbers, rounded; nothing if they do not fit.
std::optional<LatticeBox> box_of(const Size& size, const BoxSums& sums, bool has_rises) {
  LatticeBox box;
  box.size = size;
  const double count = count_of(size);
  double first = sums.value / count;
  const auto rounded = [](double number) -> std::optional<std::int32_t> {
    constexpr double kMost = std::numeric_limits<std::int32_t>::max();
    if (!(std::abs(number) < kMost)) return std::nullopt;
    return static_cast<std::int32_t>(std::lround(number));
  };
  for (std::size_t a = 0; has_rises && a < 3; ++a) {
    if (size[a] == 1) continue;
    const double mean = 0.5 * (size[a] - 1.0);
    const double variance = count * (static_cast<double>(size[a]) * size[a] - 1) / 12;
    const double slope = (sums.position_value[a] - mean * sums.value) / variance;
    first -= slope * mean;
    const auto rise = rounded(slope * (size[a] - 1));
    if (!rise) return std::nullopt;
    box.rise[a] = *rise;
  }
  const auto whole = rounded(first);
  if (!whole) return std::nullopt;
  box.first = *whole;
  return box;
}

class BoxFinder {
 public:
  BoxFinder(const LatticeSamples& samples, const LatticeBoxes& all, const BoxRules& rules,
            std::int64_t end, std::span<SampleState> states, const std::stop_token& stop)
      : values_(samples.values),
        dims_(samples.dims),
        end_{samples.dims[0], samples.dims[1], end},
        least_(all.least),
        per_value_(1 / all.step),
        most_steps_((rules.tolerance + rounding_of(all)) / all.step),
        sample_(all),
        rules_(rules),
        states_(states),
        stop_(stop) {}

  // Along row (y, z).
  void find_in_row(std::int64_t y, std::int64_t z) {
    check_stop();
    rules_.search == RunSearch::kFewest ? find_fewest(y, z) : find_greedily(y, z);
  }

  BoxesOfLayers take() { return std::move(found_); }

 private:
  void check_stop() const {
    if (stop_.stop_requested())
      throw Error(ErrorCode::kCancelled, "looking for boxes was cancelled");
  }

  // What is read is at most so far from what a box's numbers say: half a whole number, or half of
  // a float's last digit.
  static double rounding_of(const LatticeBoxes& all) {
    const double magnitude = std::max(std::abs(all.least), std::abs(all.greatest));
    return all.whole ? 0.5 : magnitude * std::ldexp(1.0, -24);
  }

  std::size_t at(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return static_cast<std::size_t>((z * dims_[1] + y) * dims_[0] + x);
  }

  void find_greedily(std::int64_t y, std::int64_t z) {
    for (std::int64_t x = 0; x < dims_[0]; ++x) {
      const SampleState state = states_[at(x, y, z)];
      if (state == SampleState::kOpen)
        put({x, y, z}, greatest_box({x, y, z}));
      else if (state != SampleState::kTaken)
        ++found_.gap_behind;
    }
  }

  void put(const Index3& begin, LatticeBox box) {
    box.gap = std::exchange(found_.gap_behind, 0);
    for (std::int64_t k = 0; k < box.size[2]; ++k) {
      for (std::int64_t j = 0; j < box.size[1]; ++j) {
        for (std::int64_t i = 0; i < box.size[0]; ++i)
          states_[at(begin[0] + i, begin[1] + j, begin[2] + k)] = SampleState::kTaken;
      }
    }
    found_.boxes.push_back(box);
  }

  // Along x as far as it goes, then as many such rows, then as many such layers.
  LatticeBox greatest_box(const Index3& begin) const {
    Growth growth = single(begin);
    const std::size_t axes = rules_.primitives == Primitives::kBoxes ? 3 : 1;
    for (std::size_t axis = 0; axis < axes; ++axis) {
      while (grow(begin, axis, growth)) {
      }
    }
    return growth.box;
  }

  struct Growth {
    LatticeBox box;
    BoxSums sums;
    double square = 0;  // of all errors
  };

  Growth single(const Index3& begin) const {
    Growth growth;
    const float value = values_[at(begin[0], begin[1], begin[2])];
    if (value != value) {
      growth.box.first = LatticeBox::kMissing;
      return growth;
    }
    growth.sums.add(steps_of(value), 0, 0, 0);
    growth.box.first = static_cast<std::int32_t>(std::lround(growth.sums.value));
    growth.square = *squares(begin, growth.box, {0, 0, 0}, {1, 1, 1});
    return growth;
  }

  double steps_of(float value) const { return (static_cast<double>(value) - least_) * per_value_; }

  // By one sample along an axis, if they are still even.
  bool grow(const Index3& begin, std::size_t axis, Growth& growth) const {
    const Size from{0, 0, 0};
    Size slab_from = from;
    Size size = growth.box.size;
    if (begin[axis] + size[axis] >= end_[axis]) return false;
    slab_from[axis] = size[axis]++;
    BoxSums sums = growth.sums;
    if (!add_slab(begin, slab_from, size, growth.box.first == LatticeBox::kMissing, sums))
      return false;
    if (growth.box.first == LatticeBox::kMissing) {
      growth.box.size = size;
      return true;
    }
    if (growth.box.rise[axis] == 0) {  // perhaps the numbers may stay
      LatticeBox same = growth.box;
      same.size = size;
      const auto more = squares(begin, same, slab_from, size);
      if (more && accept(same, sums, growth.square + *more, growth)) return true;
    }
    const std::optional<LatticeBox> box =
        box_of(size, sums, rules_.primitives != Primitives::kConstants);
    if (!box) return false;
    const auto square = squares(begin, *box, from, size);
    return square && accept(*box, sums, *square, growth);
  }

  bool accept(const LatticeBox& box, const BoxSums& sums, double square, Growth& growth) const {
    if (!(square <= rules_.rms * rules_.rms * count_of(box.size))) return false;
    growth = {box, sums, square};
    return true;
  }

  // False if some of the samples [from, to) are in no box's reach, or missing where others are not.
  bool add_slab(const Index3& begin, const Size& from, const Size& to, bool is_missing,
                BoxSums& sums) const {
    for (std::int64_t k = from[2]; k < to[2]; ++k) {
      for (std::int64_t j = from[1]; j < to[1]; ++j) {
        for (std::int64_t i = from[0]; i < to[0]; ++i) {
          const std::size_t sample = at(begin[0] + i, begin[1] + j, begin[2] + k);
          if (states_[sample] >= SampleState::kDropped) return false;
          const float value = values_[sample];
          if ((value != value) != is_missing) return false;
          if (!is_missing) sums.add(steps_of(value), i, j, k);
        }
      }
    }
    return true;
  }

  // The sum of the squared errors of the box's samples [from, to); nothing if one is too great.
  // Clamping what is read makes none greater.
  std::optional<double> squares(const Index3& begin, const LatticeBox& box, const Size& from,
                                const Size& to) const {
    const data::BoxValues steps(box);
    double sum = 0;
    for (std::int64_t k = from[2]; k < to[2]; ++k) {
      for (std::int64_t j = from[1]; j < to[1]; ++j) {
        const double row = steps.row(j, k);
        const float* const values = values_.data() + at(begin[0], begin[1] + j, begin[2] + k);
        for (std::int64_t i = from[0]; i < to[0]; ++i) {
          const double read =
              static_cast<double>(sample_.unclamped(row + static_cast<double>(i) * steps.slope()));
          const double error = read - static_cast<double>(values[i]);
          if (!(std::abs(error) <= rules_.tolerance)) return std::nullopt;
          sum += error * error;
        }
      }
    }
    return sum;
  }

  // The fewest runs of a row that begin and end at open samples, by dynamic programming: ends_[x]
  // is the best way to be done with the samples before x.
  void find_fewest(std::int64_t y, std::int64_t z) {
    constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
    struct End {
      std::int64_t runs = kNever, begin = 0;
      LatticeBox box;
      bool is_run = false;
    };
    std::vector<End> ends(static_cast<std::size_t>(dims_[0]) + 1);
    ends[0].runs = 0;
    for (std::int64_t x = 0; x < dims_[0]; ++x) {
      const std::int64_t runs = ends[static_cast<std::size_t>(x)].runs;
      if (runs == kNever) continue;
      End& next = ends[static_cast<std::size_t>(x) + 1];
      if (states_[at(x, y, z)] != SampleState::kOpen) {
        if (runs < next.runs) next = {runs, x, {}, false};
        continue;
      }
      visit_runs({x, y, z}, [&](const LatticeBox& box) {
        End& end = ends[static_cast<std::size_t>(x) + static_cast<std::size_t>(box.size[0])];
        if (runs + 1 < end.runs) end = {runs + 1, x, box, true};
      });
    }
    std::vector<const End*> way;
    for (auto x = static_cast<std::size_t>(dims_[0]); x > 0;
         x = static_cast<std::size_t>(ends[x].begin))
      way.push_back(&ends[x]);
    for (auto end = way.rbegin(); end != way.rend(); ++end) {
      if ((*end)->is_run)
        put({(*end)->begin, y, z}, (*end)->box);
      else
        ++found_.gap_behind;
    }
  }

  // All even runs that begin at a sample and end at an open one: by least squares, and what the
  // greedy search would have.
  template <class Visit>
  void visit_runs(const Index3& begin, const Visit& visit) const {
    Growth grown = single(begin);
    visit(grown.box);
    const bool is_missing = grown.box.first == LatticeBox::kMissing;
    const bool has_rises = rules_.primitives != Primitives::kConstants;
    bool grows = true;
    BoxSums sums = grown.sums;
    double squares_of_values = sums.value * sums.value;
    for (std::int64_t x = begin[0] + 1; x < end_[0]; ++x) {
      check_stop();
      const auto length = static_cast<std::int32_t>(x - begin[0]);
      const Size size{length + 1, 1, 1};
      if (!add_slab(begin, {length, 0, 0}, size, is_missing, sums)) return;
      const std::size_t sample = at(x, begin[1], begin[2]);
      const double steps = steps_of(values_[sample]);
      squares_of_values += steps * steps;
      grows = grows && grow(begin, 0, grown);
      if (!is_missing && !may_be_even(size, sums, squares_of_values, has_rises)) return;
      if (states_[sample] != SampleState::kOpen) continue;
      if (grows) {
        visit(grown.box);
      } else if (const auto box = box_of(size, sums, has_rises)) {
        Growth fitted;
        const auto square = squares(begin, *box, {0, 0, 0}, size);
        if (square && accept(*box, sums, *square, fitted)) visit(fitted.box);
      }
    }
  }

  // False if no numbers whatever bring all samples of a run within the tolerance, and so none those
  // of any longer one: the least squares' own error is too great for that.
  bool may_be_even(const Size& size, const BoxSums& sums, double squares_of_values,
                   bool has_rises) const {
    const double count = count_of(size);
    double error = squares_of_values - sums.value * sums.value / count;
    if (has_rises) {
      const double covariance = sums.position_value[0] - 0.5 * (size[0] - 1.0) * sums.value;
      error -= covariance * covariance * 12 / (count * (count * count - 1));
    }
    return error <= count * most_steps_ * most_steps_ + 1e-9 * squares_of_values;
  }

  std::span<const float> values_;
  Index3 dims_, end_;
  double least_, per_value_;
  double most_steps_;  // of the tolerance, with what rounding may add
  data::SampleOfBox sample_;
  const BoxRules& rules_;
  std::span<SampleState> states_;
  const std::stop_token& stop_;
  BoxesOfLayers found_;
};

}  // namespace

BoxesOfLayers find_even_boxes(const LatticeSamples& samples, const LatticeBoxes& all,
                              const BoxRules& rules, std::int64_t begin, std::int64_t end,
                              std::span<SampleState> states, const std::stop_token& stop) {
  BoxFinder finder(samples, all, rules, end, states, stop);
  for (std::int64_t z = begin; z < end; ++z) {
    for (std::int64_t y = 0; y < samples.dims[1]; ++y) finder.find_in_row(y, z);
  }
  return finder.take();
}

}  // namespace ovoid::fit
