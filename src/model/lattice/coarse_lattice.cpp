// SPDX-License-Identifier: Apache-2.0
// Means of samples on a lattice of twice the spacing. Input: any brick source. Output: samples in
// memory. A task is a row of bricks: their samples are brought into a window of doubles, of which
// means are taken, rows first, whose loops the compiler turns into vector code.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "data/lattice/resident_lattice.h"
#include "data/parallel.h"
#include "data/scalar_visit.h"
#include "model/coarse_field.h"
#include "model/lattice/sample_window.h"
#include "ovoid/error.h"

namespace ovoid::model {
namespace {

// Samples of a window: 256 KiB of doubles, which a second-level cache holds.
constexpr std::int64_t kWindowSamples = std::int64_t{1} << 15;

// A result is missing where less of what it stands for exists.
constexpr double kLeastShareOfSamples = 0.5;

// The samples of an axis that a new one stands for, from `first` on, and their shares.
struct Taps {
  std::int64_t first = 0;
  int count = 0;
  std::array<double, 3> weights{};  // add up to 1
};

// The axis from -1/2 to n - 1/2 is cut into ceil(n / 2) equal parts; a sample is in a part as far
// as its cell is. Of even n those are pairs, of odd n a part is less than two cells long and meets
// three at most.
std::vector<Taps> taps_of_axis(std::int64_t n) {
  const std::int64_t count = (n + 1) / 2;
  std::vector<Taps> axis(static_cast<std::size_t>(count));
  for (std::int64_t i = 0; i < count; ++i) {
    // In whole numbers, a cell being `count` long and a part n.
    Taps& taps = axis[static_cast<std::size_t>(i)];
    taps.first = i * n / count;
    for (std::int64_t cell = taps.first; cell * count < (i + 1) * n; ++cell) {
      const std::int64_t shared =
          std::min((i + 1) * n, (cell + 1) * count) - std::max(i * n, cell * count);
      taps.weights[static_cast<std::size_t>(taps.count++)] =
          static_cast<double>(shared) / static_cast<double>(n);
    }
  }
  return axis;
}

// The new samples of an axis whose taps begin in a run of `length` samples, run after run; the last
// entry is the end.
std::vector<std::int64_t> cut_axis(const std::vector<Taps>& axis, std::int64_t length) {
  std::vector<std::int64_t> cuts{0};
  for (std::size_t i = 1; i < axis.size(); ++i) {
    if (axis[i].first / length != axis[i - 1].first / length)
      cuts.push_back(static_cast<std::int64_t>(i));
  }
  cuts.push_back(static_cast<std::int64_t>(axis.size()));
  return cuts;
}

// Rounded to even where it lies between two integers, so that means of means do not drift: to a
// double of 1.5 * 2^52 an integer is the last digit. Means lie within the type's range.
template <class T>
T stored_mean(double mean) noexcept {
  if constexpr (std::is_floating_point_v<T>) {
    return static_cast<T>(mean);
  } else {
    constexpr double kWhole = 0x1.8p52;
    return static_cast<T>(static_cast<std::int32_t>((mean + kWhole) - kWhole));
  }
}

// What a mean of samples becomes of which some are missing.
struct Rule {
  bool is_sum = false;
  double zero = 0;  // the stored number that stands for the value 0

  // `sum` over the share `share` of the weights.
  double mean(double sum, double share) const noexcept {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    if (!is_sum) return share >= kLeastShareOfSamples ? sum / share : kNone;
    // What is missing adds nothing to a sum of kernels: the mass is kept.
    return share > 0 ? sum + (1 - share) * zero : kNone;
  }
};

Rule rule_of(const LatticeField& field) {
  return {field.reconstruction() == Reconstruction::kSum,
          -field.source().value_offset() / field.source().value_scale()};
}

// Makes the samples of boxes of the result; one per thread and range.
template <class T>
class Averager {
 public:
  Averager(const LatticeField& field, const std::array<std::vector<Taps>, 3>& axes, T* out)
      : source_(field.source()), axes_(axes), out_(out), rule_(rule_of(field)) {}

  // The new samples lo <= (i, j, k) < hi.
  void make(const Index3& lo, const Index3& hi) {
    Index3 first, end;
    for (std::size_t a = 0; a < 3; ++a) {
      first[a] = at(a, lo[a]).first;
      end[a] = at(a, hi[a] - 1).first + at(a, hi[a] - 1).count;
    }
    window_.load(source_, first, end);
    sums_.resize(static_cast<std::size_t>(end[0] - first[0]));
    shares_.resize(sums_.size());
    for (std::int64_t k = lo[2]; k < hi[2]; ++k) {
      for (std::int64_t j = lo[1]; j < hi[1]; ++j) {
        T* const row = out_ + size(0) * (j + size(1) * k);
        window_.has_missing ? make_row_with_holes(row, lo[0], hi[0], j, k)
                            : make_row(row, lo[0], hi[0], j, k);
      }
    }
  }

 private:
  std::int64_t size(std::size_t a) const noexcept {
    return static_cast<std::int64_t>(axes_[a].size());
  }
  const Taps& at(std::size_t a, std::int64_t i) const noexcept {
    return axes_[a][static_cast<std::size_t>(i)];
  }

  // Calls add(row of the window, weight) for the rows that a row of the result stands for.
  template <class Add>
  void for_rows(std::int64_t j, std::int64_t k, const Add& add) const {
    const Taps& y = at(1, j);
    const Taps& z = at(2, k);
    for (int c = 0; c < z.count; ++c) {
      for (int b = 0; b < y.count; ++b)
        add(window_.row(y.first + b, z.first + c),
            y.weights[static_cast<std::size_t>(b)] * z.weights[static_cast<std::size_t>(c)]);
    }
  }

  double along_x(const std::vector<double>& row, const Taps& taps) const noexcept {
    const double* const from = row.data() + (taps.first - window_.lo[0]);
    double sum = taps.weights[0] * from[0];
    for (int a = 1; a < taps.count; ++a) sum += taps.weights[static_cast<std::size_t>(a)] * from[a];
    return sum;
  }

  void make_row(T* row, std::int64_t lo, std::int64_t hi, std::int64_t j, std::int64_t k) {
    const std::size_t count = sums_.size();
    double* sums = sums_.data();
    std::fill_n(sums, count, 0.0);
    for_rows(j, k, [&](const double* from, double weight) {
      for (std::size_t i = 0; i < count; ++i) sums[i] += weight * from[i];
    });
    if (2 * size(0) == static_cast<std::int64_t>(source_.geometry().dims[0])) {  // pairs
      for (std::int64_t i = lo; i < hi; ++i) {
        row[i] = stored_mean<T>(0.5 * (sums[0] + sums[1]));
        sums += 2;
      }
      return;
    }
    for (std::int64_t i = lo; i < hi; ++i) row[i] = stored_mean<T>(along_x(sums_, at(0, i)));
  }

  void make_row_with_holes(T* row, std::int64_t lo, std::int64_t hi, std::int64_t j,
                           std::int64_t k) {
    std::fill(sums_.begin(), sums_.end(), 0.0);
    std::fill(shares_.begin(), shares_.end(), 0.0);
    for_rows(j, k, [&](const double* from, double weight) {
      for (std::size_t i = 0; i < sums_.size(); ++i) {
        const bool exists = !std::isnan(from[i]);
        sums_[i] += exists ? weight * from[i] : 0.0;
        shares_[i] += exists ? weight : 0.0;
      }
    });
    for (std::int64_t i = lo; i < hi; ++i)
      row[i] = stored_mean<T>(rule_.mean(along_x(sums_, at(0, i)), along_x(shares_, at(0, i))));
  }

  const BrickSource& source_;
  const std::array<std::vector<Taps>, 3>& axes_;
  T* const out_;
  Rule rule_;
  SampleWindow window_;
  std::vector<double> sums_, shares_;  // a row of the window
};

template <class T>
void average(const LatticeField& field, const CoarseOptions& options, T* out) {
  const Index3& dims = field.geometry().dims;
  const std::int64_t edge = field.source().brick_edge();
  const std::array<std::vector<Taps>, 3> axes{taps_of_axis(dims[0]), taps_of_axis(dims[1]),
                                              taps_of_axis(dims[2])};
  const std::int64_t bricks_in_row =
      std::max<std::int64_t>(1, kWindowSamples / (edge * edge * edge));
  const std::vector<std::int64_t> x = cut_axis(axes[0], edge * bricks_in_row);
  const std::vector<std::int64_t> y = cut_axis(axes[1], edge);
  const std::vector<std::int64_t> z = cut_axis(axes[2], edge);
  const auto nx = static_cast<std::int64_t>(x.size() - 1);
  const auto ny = static_cast<std::int64_t>(y.size() - 1);
  const auto nz = static_cast<std::int64_t>(z.size() - 1);
  CoarseProgress progress(options, nx * ny * nz);
  data::parallel_ranges({nx * ny * nz, 8, options.threads, options.stop},
                        [&](std::int64_t begin, std::int64_t end) {
                          Averager<T> averager(field, axes, out);
                          for (std::int64_t task = begin; task < end; ++task) {
                            const auto i = static_cast<std::size_t>(task % nx);
                            const auto j = static_cast<std::size_t>(task / nx % ny);
                            const auto k = static_cast<std::size_t>(task / nx / ny);
                            averager.make({x[i], y[j], z[k]}, {x[i + 1], y[j + 1], z[k + 1]});
                          }
                          progress.add(end - begin);
                        });
}

// The same box in the world, of half as many samples along each axis.
LatticeGeometry halved(const LatticeGeometry& fine) {
  LatticeGeometry coarse = fine;
  Vec3 scale;
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<std::size_t>(a);
    coarse.dims[i] = (fine.dims[i] + 1) / 2;
    scale[a] = static_cast<double>(fine.dims[i]) / static_cast<double>(coarse.dims[i]);
  }
  coarse.world_from_index.translate(0.5 * (scale - Vec3::Ones()));
  coarse.world_from_index.scale(scale);
  return coarse;
}

// Twice the axis vectors. The new samples lie on every second old one of the first sublattice,
// along each axis, or, in odd layers, one further.
LatticeGeometry halved_body_centred(const LatticeGeometry& fine) {
  LatticeGeometry coarse = fine;
  for (std::int64_t& n : coarse.dims) n = (n + 1) / 2;
  coarse.world_from_index.scale(2.0);
  return coarse;
}

// An offset to a sample (layers along z), and its share.
struct Neighbor {
  Index3 offset;
  double weight;
};

// What a new body-centred sample stands for: its cell, twice as large as an old one, holds the old
// sample at its place; on its 8 hexagonal and 6 square faces lie others, half of each.
std::vector<Neighbor> neighbors_in_cell() {
  std::vector<Neighbor> cell{{{0, 0, 0}, 1.0}};
  for (std::int64_t sign : {-1, 1}) {
    cell.push_back({{sign, 0, 0}, 0.5});
    cell.push_back({{0, sign, 0}, 0.5});
    cell.push_back({{0, 0, 2 * sign}, 0.5});
    for (std::int64_t j : {-1, 0})
      for (std::int64_t i : {-1, 0}) cell.push_back({{i, j, sign}, 0.5});
  }
  return cell;
}

// The mean around an old sample's place, which may lie one beyond the last.
double mean_in_cell(const SampleWindow& window, const std::vector<Neighbor>& cell,
                    const Index3& place, const Rule& rule) {
  double sum = 0, share = 0, whole = 0;
  for (const Neighbor& neighbor : cell) {
    Index3 at = place;
    bool is_inside = true;
    for (std::size_t a = 0; a < 3; ++a) {
      at[a] += neighbor.offset[a];
      is_inside &= at[a] >= window.lo[a] && at[a] < window.hi[a];
    }
    if (!is_inside) continue;
    whole += neighbor.weight;
    const double number = window.row(at[1], at[2])[at[0] - window.lo[0]];
    if (std::isnan(number)) continue;
    sum += neighbor.weight * number;
    share += neighbor.weight;
  }
  return rule.mean(sum / whole, share / whole);
}

template <class T>
void average_body_centred(const LatticeField& field, const LatticeGeometry& coarse,
                          const CoarseOptions& options, T* out) {
  const Index3& fine = field.geometry().dims;
  const std::int64_t edge = field.source().brick_edge();
  const Rule rule = rule_of(field);
  const std::vector<Neighbor> cell = neighbors_in_cell();
  // The new samples of a brick's box, of whole rows along x.
  const Index3& dims = coarse.dims;
  const std::int64_t ny = (dims[1] + edge / 2 - 1) / (edge / 2);
  const std::int64_t nz = (dims[2] + edge - 1) / edge;
  CoarseProgress progress(options, ny * nz);
  data::parallel_ranges({ny * nz, 1, options.threads, options.stop}, [&](std::int64_t begin,
                                                                         std::int64_t end) {
    SampleWindow window;
    for (std::int64_t task = begin; task < end; ++task) {
      const Index3 lo{0, task % ny * (edge / 2), task / ny * edge};
      const Index3 hi{dims[0], std::min(lo[1] + edge / 2, dims[1]),
                      std::min(lo[2] + edge, dims[2])};
      // All that is in the cells: one sample before, two behind (odd layers lie one further).
      window.load(
          field.source(),
          {0, std::max<std::int64_t>(2 * lo[1] - 1, 0), std::max<std::int64_t>(2 * lo[2] - 2, 0)},
          {fine[0], std::min(2 * hi[1] + 1, fine[1]), std::min(2 * hi[2] + 1, fine[2])});
      for (std::int64_t k = lo[2]; k < hi[2]; ++k) {
        for (std::int64_t j = lo[1]; j < hi[1]; ++j) {
          T* const row = out + dims[0] * (j + dims[1] * k);
          for (std::int64_t i = 0; i < dims[0]; ++i)
            row[i] = stored_mean<T>(
                mean_in_cell(window, cell, {2 * i + k % 2, 2 * j + k % 2, 2 * k}, rule));
        }
      }
    }
    progress.add(end - begin);
  });
}

template <class T>
LatticeField coarse_of_type(const LatticeField& field, const CoarseOptions& options,
                            ScalarType type) {
  const bool is_cartesian = field.geometry().kind == LatticeKind::kCartesian;
  const LatticeGeometry geometry =
      is_cartesian ? halved(field.geometry()) : halved_body_centred(field.geometry());
  const auto count = static_cast<std::size_t>(num_samples(geometry.dims));
  const std::shared_ptr<T[]> samples = std::make_shared_for_overwrite<T[]>(count);
  is_cartesian ? average(field, options, samples.get())
               : average_body_centred(field, geometry, options, samples.get());
  const BrickSource& source = field.source();
  ResidentLatticeOptions resident;
  resident.range_reach = field.index_kernel().support_radius();
  resident.value_scale = source.value_scale();
  resident.value_offset = source.value_offset();
  resident.threads = options.threads;
  resident.stop = options.stop;
  const Bytes bytes{samples, std::as_bytes(std::span<const T>(samples.get(), count))};
  return {std::make_shared<ResidentLattice>(geometry, type, bytes, resident), field.kernel(),
          field.reconstruction(), field.value_range()};
}

}  // namespace

LatticeField coarse_lattice(const LatticeField& field, const CoarseOptions& options) {
  const ScalarType type = field.source().acquire(0, 0, 0, 0.0).type;
  return data::visit_scalar(type, [&]<class T>(std::type_identity<T>) -> LatticeField {
    if constexpr (std::is_same_v<T, float> || (std::is_integral_v<T> && sizeof(T) <= 2)) {
      return coarse_of_type<T>(field, options, type);
    } else {
      throw Error(ErrorCode::kUnsupported,
                  fmt::format("brick of type {}: expected uint8, int8, uint16, int16 or float32",
                              name_of(type)));
    }
  });
}

}  // namespace ovoid::model
