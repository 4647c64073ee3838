// SPDX-License-Identifier: Apache-2.0
#include "fit/level_fitter.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

#include "data/parallel.h"
#include "fit/conjugate_gradients.h"

namespace ovoid::fit {
namespace {

using data::LevelAxis;

// Numbers that are worked on, and added up, together: sums do not depend on the number of threads.
constexpr std::int64_t kGrain = 1 << 18;
// Levels are added until one has so few nodes along its longest axis.
constexpr std::int64_t kFewNodes = 12;
constexpr int kMostLevels = 10;
// Of the residual of the normal equations, over what it was: where steps end.
constexpr double kLeastEnergy = 1e-10;

int levels_for(const Index3& dims) {
  const std::int64_t longest = *std::max_element(dims.begin(), dims.end());
  int levels = 1;
  while (levels < kMostLevels && (longest >> (levels - 1)) > kFewNodes) ++levels;
  return levels;
}

// Cholesky's factor of a level's products along an axis: row i holds l(i, i - j) by j, and of the
// diagonal the inverse.
std::vector<std::array<float, LevelAxis::kTaps>> factor_of(const LevelAxis& axis) {
  constexpr std::size_t kTaps = LevelAxis::kTaps;
  std::vector<std::array<double, kTaps>> l = axis.products();
  for (std::size_t i = 0; i < l.size(); ++i) {
    for (std::size_t j = std::min(kTaps - 1, i) + 1; j-- > 0;) {
      double sum = l[i][j];
      for (std::size_t k = j + 1; k < kTaps && k <= i; ++k) sum -= l[i][k] * l[i - j][k - j];
      // The last node of a lattice may hang over it, and hold next to nothing.
      l[i][j] = j > 0 ? sum * l[i - j][0] : 1 / std::sqrt(std::max(sum, 1e-6));
    }
  }
  std::vector<std::array<float, kTaps>> factor(l.size());
  for (std::size_t i = 0; i < l.size(); ++i)
    std::transform(l[i].begin(), l[i].end(), factor[i].begin(),
                   [](double value) { return static_cast<float>(value); });
  return factor;
}

}  // namespace

template <class Term>
double LevelFitter::sum(std::size_t count, const Term& term) const {
  const auto total = static_cast<std::int64_t>(count);
  std::vector<double> parts(static_cast<std::size_t>((total + kGrain - 1) / kGrain));
  data::parallel_ranges({total, kGrain, work_.threads, work_.stop},
                        [&](std::int64_t begin, std::int64_t end) {
                          double part = 0;
                          for (std::int64_t i = begin; i < end; ++i)
                            part += term(static_cast<std::size_t>(i));
                          parts[static_cast<std::size_t>(begin / kGrain)] = part;
                        });
  double all = 0;
  for (const double part : parts) all += part;
  return all;
}

template <class Body>
void LevelFitter::for_each(std::size_t count, const Body& body) const {
  data::parallel_ranges({static_cast<std::int64_t>(count), kGrain, work_.threads, work_.stop},
                        [&](std::int64_t begin, std::int64_t end) {
                          for (std::int64_t i = begin; i < end; ++i)
                            body(static_cast<std::size_t>(i));
                        });
}

LevelFitter::LevelFitter(const Index3& dims, std::vector<float> samples, const Limits& limits,
                         const data::LevelWork& work, std::size_t most_pairs)
    : basis_(dims, levels_for(dims)),
      work_(work),
      limits_(limits),
      most_pairs_(most_pairs),
      pairs_(basis_),
      samples_(std::move(samples)),
      residual_(samples_),
      weights_(basis_.num_weights()),
      inverse_norms_(basis_.num_weights()),
      products_(basis_.num_weights()),
      is_kernel_(basis_.num_weights()) {
  num_there_ = sum(samples_.size(), [&](std::size_t i) { return std::isnan(samples_[i]) ? 0 : 1; });
  for (int level = 0; level < basis_.num_levels(); ++level) {
    std::array<std::vector<double>, 3> norms;
    for (int a = 0; a < 3; ++a)
      norms[static_cast<std::size_t>(a)] = basis_.axis(level, a).squared_norms();
    std::size_t node = basis_.offset(level);
    for (const double z : norms[2]) {
      for (const double y : norms[1]) {
        for (const double x : norms[0])
          inverse_norms_[node++] = static_cast<float>(1 / std::sqrt(std::max(x * y * z, 1e-12)));
      }
    }
  }
}

void LevelFitter::refresh_residual() {
  if (std::exchange(is_residual_, true)) return;
  std::fill(residual_.begin(), residual_.end(), 0.0F);
  basis_.expand(weights_, 0, basis_.num_levels(), 1, residual_, work_);
  for_each(residual_.size(), [&](std::size_t i) {
    const float sample = samples_[i], sum = residual_[i];
    const bool is_beyond =
        (sample <= limits_.least && sum < sample) || (sample >= limits_.greatest && sum > sample);
    residual_[i] = is_beyond || std::isnan(sample) ? 0 : sample - sum;
  });
}

void LevelFitter::refresh_products() {
  if (std::exchange(are_products_, true)) return;
  refresh_residual();
  basis_.reduce(residual_, 0, basis_.num_levels(), products_, work_);
}

std::span<const float> LevelFitter::residual() {
  refresh_residual();
  return residual_;
}

double LevelFitter::mean_square() {
  refresh_residual();
  const double square = sum(residual_.size(), [&](std::size_t i) {
    const auto r = static_cast<double>(residual_[i]);
    return r * r;
  });
  return square / std::max(1.0, num_there_);
}

// Solves with Cholesky's factor along one axis, all lines of it.
void LevelFitter::solve_along(int level, int a, std::span<float> weights) const {
  constexpr std::int64_t kTaps = LevelAxis::kTaps;
  const auto factor = factor_of(basis_.axis(level, a));
  const Index3 nodes = basis_.nodes(level);
  const std::int64_t size = nodes[static_cast<std::size_t>(a)];
  // Lines lie side by side along x, or one by one; `step` from node to node, `outer` from one
  // bundle of lines to the next.
  const std::int64_t step = a == 0 ? 1 : a == 1 ? nodes[0] : nodes[0] * nodes[1];
  const std::int64_t width = a == 0 ? 1 : nodes[0];
  const std::int64_t bundles = a == 0 ? nodes[1] * nodes[2] : a == 1 ? nodes[2] : nodes[1];
  const std::int64_t outer = a == 0 ? nodes[0] : a == 1 ? nodes[0] * nodes[1] : nodes[0];
  float* const all = weights.data() + basis_.offset(level);
  const auto at = [&](std::int64_t i) { return static_cast<std::size_t>(i); };
  data::parallel_ranges(
      {bundles, std::max<std::int64_t>(1, 65536 / (size * width)), work_.threads, work_.stop},
      [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t bundle = begin; bundle < end; ++bundle) {
          float* const lines = all + bundle * outer;
          for (std::int64_t i = 0; i < size; ++i) {
            float* const to = lines + i * step;
            for (std::int64_t j = 1; j < kTaps && j <= i; ++j) {
              const float share = factor[at(i)][at(j)];
              for (std::int64_t x = 0; x < width; ++x) to[x] -= share * to[x - j * step];
            }
            for (std::int64_t x = 0; x < width; ++x) to[x] *= factor[at(i)][0];
          }
          for (std::int64_t i = size; i-- > 0;) {
            float* const to = lines + i * step;
            for (std::int64_t j = 1; j < kTaps && i + j < size; ++j) {
              const float share = factor[at(i + j)][at(j)];
              for (std::int64_t x = 0; x < width; ++x) to[x] -= share * to[x + j * step];
            }
            for (std::int64_t x = 0; x < width; ++x) to[x] *= factor[at(i)][0];
          }
        }
      });
}

void LevelFitter::prefilter(int level, std::span<float> weights) const {
  for (int a = 0; a < 3; ++a) solve_along(level, a, weights);
}

void LevelFitter::clear_holes() {
  for_each(residual_.size(), [&](std::size_t i) {
    if (std::isnan(samples_[i])) residual_[i] = 0;
  });
}

void LevelFitter::start(double threshold) {
  residual_ = samples_;
  clear_holes();
  num_kernels_ = 0;
  for (int level = basis_.num_levels() - 1; level >= 0; --level) {
    basis_.reduce(residual_, level, level + 1, products_, work_);
    prefilter(level, products_);
    const std::size_t begin = basis_.offset(level);
    const std::size_t count = basis_.offset(level + 1) - begin;
    num_kernels_ += static_cast<std::int64_t>(sum(count, [&](std::size_t i) {
      const std::size_t node = begin + i;
      const bool keeps =
          std::abs(products_[node]) > static_cast<float>(threshold) * inverse_norms_[node];
      is_kernel_[node] = static_cast<std::uint8_t>(keeps);
      weights_[node] = keeps ? products_[node] : 0;
      return keeps ? 1.0 : 0.0;
    }));
    basis_.expand(weights_, level, level + 1, -1, residual_, work_);
    clear_holes();  // which are filled by what coarser levels make of them
  }
  is_residual_ = are_products_ = false;
}

void LevelFitter::grow(std::int64_t count) {
  if (count <= 0) return;
  refresh_products();
  const auto score = [&](std::size_t node) {
    return is_kernel_[node] != 0 ? 0.0F : std::abs(products_[node]) * inverse_norms_[node];
  };
  // Counts of scores by their leading bits, those that decide first.
  constexpr int kShift = 15;
  constexpr std::size_t kBins = std::size_t{1} << 16;
  const auto total = static_cast<std::int64_t>(products_.size());
  const std::int64_t part = std::max(kGrain, (total + 63) / 64);
  std::vector<std::vector<std::uint32_t>> counts(
      static_cast<std::size_t>((total + part - 1) / part));
  data::parallel_ranges(
      {total, part, work_.threads, work_.stop}, [&](std::int64_t begin, std::int64_t end) {
        auto& own = counts[static_cast<std::size_t>(begin / part)];
        own.resize(kBins);
        for (std::int64_t i = begin; i < end; ++i)
          ++own[std::bit_cast<std::uint32_t>(score(static_cast<std::size_t>(i))) >> kShift];
      });
  std::size_t bin = kBins;  // the last that is needed, and how many of it
  std::int64_t above = 0, of_bin = 0;
  while (bin > 1 && above + of_bin < count) {
    --bin;
    above += of_bin;
    of_bin = 0;
    for (const auto& own : counts) of_bin += own[bin];
  }
  std::int64_t left = count - above;
  for (std::size_t node = 0; node < products_.size(); ++node) {
    const std::size_t own = std::bit_cast<std::uint32_t>(score(node)) >> kShift;
    if (own < bin || (own == bin && left-- <= 0)) continue;
    is_kernel_[node] = 1;
    ++num_kernels_;
  }
}

void LevelFitter::add_kernel(std::size_t sample) {
  num_kernels_ += static_cast<std::int64_t>(is_kernel_[sample] == 0);
  is_kernel_[sample] = 1;
}

void LevelFitter::prune(std::int64_t count) {
  if (num_kernels_ <= count) return;
  std::vector<std::pair<float, std::uint32_t>> held;
  held.reserve(static_cast<std::size_t>(num_kernels_));
  for (std::size_t node = 0; node < weights_.size(); ++node) {
    if (is_kernel_[node] != 0)
      held.emplace_back(std::abs(weights_[node]) / inverse_norms_[node],
                        static_cast<std::uint32_t>(node));
  }
  const auto last =
      held.begin() + static_cast<std::ptrdiff_t>(held.size()) - static_cast<std::ptrdiff_t>(count);
  std::nth_element(held.begin(), last - 1, held.end());
  for (auto it = held.begin(); it != last; ++it) {
    is_kernel_[it->second] = 0;
    weights_[it->second] = 0;
  }
  num_kernels_ = count;
  is_residual_ = are_products_ = false;
}

std::vector<std::uint32_t> LevelFitter::kernels() const {
  std::vector<std::uint32_t> nodes;
  nodes.reserve(static_cast<std::size_t>(num_kernels_));
  for (std::size_t node = 0; node < is_kernel_.size(); ++node) {
    if (is_kernel_[node] != 0) nodes.push_back(static_cast<std::uint32_t>(node));
  }
  return nodes;
}

void LevelFitter::fit(int iterations) {
  const std::vector<std::uint32_t> nodes = kernels();
  if (pairs_.assemble(nodes, most_pairs_, work_))
    fit_few(nodes, iterations);
  else
    fit_many(iterations);
}

// Preconditioned by the diagonal, which is the kernels' squared norms; so below.
void LevelFitter::fit_few(const std::vector<std::uint32_t>& nodes, int iterations) {
  refresh_products();
  const std::size_t count = nodes.size();
  std::vector<double> values(count), left(count);
  for (std::size_t i = 0; i < count; ++i) {
    values[i] = static_cast<double>(weights_[nodes[i]]);
    left[i] = static_cast<double>(products_[nodes[i]]);
  }
  const auto multiply = [&](const std::vector<double>& of, std::vector<double>& product) {
    pairs_.multiply(of, product, work_);
  };
  const auto precondition = [&](const std::vector<double>& residual, std::vector<double>& scaled) {
    for (std::size_t i = 0; i < count; ++i) {
      const auto inverse = static_cast<double>(inverse_norms_[nodes[i]]);
      scaled[i] = residual[i] * inverse * inverse;
    }
  };
  PlainSystem system(values, std::move(left), multiply, precondition);
  conjugate_gradients(system, iterations, kLeastEnergy, [](double) {});
  for (std::size_t i = 0; i < count; ++i) weights_[nodes[i]] = static_cast<float>(values[i]);
  is_residual_ = are_products_ = false;
}

// The same system through the samples, whose residual is carried along: then a product with the
// matrix is what a direction makes of the samples.
class LevelFitter::ThroughSamples {
 public:
  explicit ThroughSamples(LevelFitter& fitter)
      : of_(fitter), direction_(fitter.products_.size()), change_(fitter.residual_.size()) {}

  double energy() const {
    return of_.sum(direction_.size(), [&](std::size_t node) {
      return static_cast<double>(of_.products_[node]) * static_cast<double>(preconditioned(node));
    });
  }
  void turn(double growth) {
    const auto ratio = static_cast<float>(growth);
    of_.for_each(direction_.size(), [&](std::size_t node) {
      direction_[node] = preconditioned(node) + ratio * direction_[node];
    });
  }
  double look() {
    std::fill(change_.begin(), change_.end(), 0.0F);
    of_.basis_.expand(direction_, 0, of_.basis_.num_levels(), 1, change_, of_.work_);
    return of_.sum(change_.size(), [&](std::size_t k) {
      return static_cast<double>(change_[k]) * static_cast<double>(change_[k]);
    });
  }
  void step(double length) {
    const auto step = static_cast<float>(length);
    of_.for_each(direction_.size(),
                 [&](std::size_t node) { of_.weights_[node] += step * direction_[node]; });
    of_.for_each(change_.size(), [&](std::size_t k) { of_.residual_[k] -= step * change_[k]; });
    of_.basis_.reduce(of_.residual_, 0, of_.basis_.num_levels(), of_.products_, of_.work_);
  }

 private:
  float preconditioned(std::size_t node) const {
    return of_.is_kernel_[node] != 0
               ? of_.products_[node] * of_.inverse_norms_[node] * of_.inverse_norms_[node]
               : 0.0F;
  }

  LevelFitter& of_;
  Weights direction_;
  std::vector<float> change_;
};

void LevelFitter::fit_many(int iterations) {
  refresh_products();
  ThroughSamples system(*this);
  conjugate_gradients(system, iterations, kLeastEnergy, [](double) {});
  is_residual_ = are_products_ = false;
}

}  // namespace ovoid::fit
