// SPDX-License-Identifier: Apache-2.0
// In:  extinction per cell. Out: the light that arrives, per cell, a mean over directions.
//
// A direction is swept slice by slice across the axis that it is steepest along. Light is kept in
// columns that lean as its rays do, so that a column is one ray and light does not spread sideways:
// a slice's extinction is read between its cells, and what arrives is read between the columns.
// Loops over a row's cells are plain arithmetic, which the compiler makes vectors of.
//
// The directions that are steepest along one axis share a copy of the volume with that axis as its
// slices. They are dealt to a few hands, each of which has a sum of its own and adds its directions
// in their order; the hands' sums are added in theirs: so the number of threads cannot be seen. Of
// fewer threads than hands so many work at once, since each has the memory of a volume.
#include "render/light/light_sweep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>

#include "data/parallel.h"

namespace ovoid {
namespace {

// The lattice's axes as a sweep goes through them: slices, rows, cells of a row.
struct SweepAxes {
  int slice, row, cell;
};

// More would be faster on many threads, and each takes the memory of a volume.
constexpr std::size_t kHands = 4;

constexpr std::array<SweepAxes, 3> kSweepAxes = {{{0, 2, 1}, {1, 2, 0}, {2, 1, 0}}};

// A volume with other axes in memory.
struct Reordered {
  SweepAxes axes;
  std::int64_t slices, rows, cells;
  std::vector<float> values;  // [slices][rows][cells]

  Reordered(const Index3& dims, const SweepAxes& as)
      : axes(as),
        slices(dims[static_cast<std::size_t>(as.slice)]),
        rows(dims[static_cast<std::size_t>(as.row)]),
        cells(dims[static_cast<std::size_t>(as.cell)]),
        values(static_cast<std::size_t>(slices * rows * cells), 0.0F) {}
  float* slice(std::int64_t s) { return values.data() + s * rows * cells; }
  const float* slice(std::int64_t s) const { return values.data() + s * rows * cells; }
};

// The cells that surfaces pass through, slice by slice, in their order within each.
class CrossedSlices {
 public:
  struct Cell {
    std::int32_t row, cell;
    std::array<float, 6> form;  // along slices, rows, cells: ss, rr, cc, rc, cs, sr
  };

  CrossedSlices(const std::vector<CrossedCell>& crossed, const SweepAxes& axes,
                std::int64_t num_slices)
      : first_(static_cast<std::size_t>(num_slices) + 1, 0), cells_(crossed.size()) {
    const auto along = [](const CrossedCell& one, int axis) {
      return one.cell[static_cast<std::size_t>(axis)];
    };
    for (const CrossedCell& one : crossed)
      ++first_[static_cast<std::size_t>(along(one, axes.slice)) + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    const std::array<int, 3> order{axes.slice, axes.row, axes.cell};
    for (const CrossedCell& one : crossed) {
      Cell& to = cells_[next[static_cast<std::size_t>(along(one, axes.slice))]++];
      to.row = along(one, axes.row);
      to.cell = along(one, axes.cell);
      for (std::size_t i = 0; i < 3; ++i) {
        to.form[i] = one.form[static_cast<std::size_t>(order[i])];
        // Of two axes' product the place is the third's: no axis of a pair is it.
        to.form[3 + i] = one.form[3 + static_cast<std::size_t>(order[i])];
      }
    }
  }

  std::span<const Cell> of(std::int64_t slice) const {
    const auto s = static_cast<std::size_t>(slice);
    return std::span(cells_).subspan(first_[s], first_[s + 1] - first_[s]);
  }

 private:
  std::vector<std::size_t> first_;
  std::vector<Cell> cells_;
};

// Calls body(place in `to`'s memory, place in the lattice's).
template <class Body>
void for_each_cell(const Reordered& to, const Index3& dims, const Body& body) {
  const std::array<std::int64_t, 3> strides{1, dims[0], dims[0] * dims[1]};
  const auto stride = [&](int a) { return strides[static_cast<std::size_t>(a)]; };
  std::size_t at = 0;
  for (std::int64_t s = 0; s < to.slices; ++s) {
    for (std::int64_t r = 0; r < to.rows; ++r) {
      for (std::int64_t c = 0; c < to.cells; ++c, ++at) {
        body(at, static_cast<std::size_t>(s * stride(to.axes.slice) + r * stride(to.axes.row) +
                                          c * stride(to.axes.cell)));
      }
    }
  }
}

// e^-x for x >= 0 as the reciprocal of a polynomial: within 0.002, and 1 at 0.
inline float attenuation(float x) {
  const float series =
      1 + x * (1 + x * (1.0F / 2 +
                        x * (1.0F / 6 + x * (1.0F / 24 + x * (1.0F / 120 + x * (1.0F / 720))))));
  return 1 / series;
}

// One direction.
class Sweep {
 public:
  // `towards_light`: in cells, per world length.
  Sweep(const Reordered& extinction, const CrossedSlices& crossed, const Vec3& towards_light,
        const LightWay& way, float weight, Reordered& sum)
      : extinction_(extinction),
        crossed_(crossed),
        sum_(sum),
        is_from_end_(towards_light[extinction.axes.slice] > 0),
        weight_(weight) {
    const double steepest = std::abs(towards_light[extinction.axes.slice]);
    const double length = 1 / steepest;  // world, from slice to slice
    per_length_ = static_cast<float>(steepest);
    const double to_slice = is_from_end_ ? 1 : -1;
    step_ = {static_cast<float>(to_slice),
             static_cast<float>(towards_light[extinction.axes.row] / steepest),
             static_cast<float>(towards_light[extinction.axes.cell] / steepest)};
    absorption_ = static_cast<float>(way.share_of_extinction * length);
    regain_ = static_cast<float>(way.regain * length);
    row_drift_ = towards_light[extinction.axes.row] / steepest;
    cell_drift_ = towards_light[extinction.axes.cell] / steepest;
    const auto last = static_cast<double>(extinction.slices - 1);
    first_row_ = static_cast<std::int64_t>(std::floor(std::min(0.0, row_drift_ * last)));
    first_cell_ = static_cast<std::int64_t>(std::floor(std::min(0.0, cell_drift_ * last)));
    const auto span = [&](std::int64_t count, double drift) {
      return count + 3 + static_cast<std::int64_t>(std::ceil(std::abs(drift) * last));
    };
    stride_ = span(extinction.cells, cell_drift_);
    light_.assign(static_cast<std::size_t>(stride_ * span(extinction.rows, row_drift_)), 1.0F);
    padded_stride_ = extinction.cells + 2;
    padded_.assign(static_cast<std::size_t>(padded_stride_ * (extinction.rows + 2)), 0.0F);
  }

  void run() {
    for (std::int64_t j = 0; j < extinction_.slices; ++j) {
      const std::int64_t slice = is_from_end_ ? extinction_.slices - 1 - j : j;
      const double row_shift = row_drift_ * static_cast<double>(j);
      const double cell_shift = cell_drift_ * static_cast<double>(j);
      const double row = std::floor(row_shift);
      const double cell = std::floor(cell_shift);
      float* const window = light_.data() +
                            (static_cast<std::int64_t>(row) - first_row_) * stride_ +
                            (static_cast<std::int64_t>(cell) - first_cell_);
      const Fraction at{static_cast<float>(row_shift - row), static_cast<float>(cell_shift - cell)};
      arrive(window, at, sum_.slice(slice));
      pad(extinction_.slice(slice));
      add_crossed(slice);
      pass(window, at);
    }
  }

 private:
  struct Fraction {
    float row, cell;
  };

  // Cell (r, c) lies between columns (r, c) and (r + 1, c + 1) of the window.
  void arrive(const float* window, const Fraction& at, float* sum) const {
    const float w00 = weight_ * (1 - at.row) * (1 - at.cell),
                w01 = weight_ * (1 - at.row) * at.cell;
    const float w10 = weight_ * at.row * (1 - at.cell), w11 = weight_ * at.row * at.cell;
    for (std::int64_t r = 0; r < extinction_.rows; ++r) {
      const float* const __restrict near = window + r * stride_;
      const float* const __restrict far = near + stride_;
      float* const __restrict to = sum + r * extinction_.cells;
      for (std::int64_t c = 0; c < extinction_.cells; ++c)
        to[c] += w00 * near[c] + w01 * near[c + 1] + w10 * far[c] + w11 * far[c + 1];
    }
  }

  // With nothing around the slice.
  void pad(const float* slice) {
    for (std::int64_t r = 0; r < extinction_.rows; ++r) {
      std::copy_n(slice + r * extinction_.cells, extinction_.cells,
                  padded_.data() + (r + 1) * padded_stride_ + 1);
    }
  }

  // What surfaces absorb on the way through the slice, as extinction.
  void add_crossed(std::int64_t slice) {
    const auto [s, r, c] = step_;
    for (const CrossedSlices::Cell& at : crossed_.of(slice)) {
      const auto& f = at.form;
      const float squared = f[0] * s * s + f[1] * r * r + f[2] * c * c +
                            2 * (f[3] * r * c + f[4] * c * s + f[5] * s * r);
      padded_[static_cast<std::size_t>((at.row + 1) * padded_stride_ + at.cell + 1)] +=
          std::sqrt(std::max(squared, 0.0F)) * per_length_;
    }
  }

  // Column (r, c) of the window meets the slice between cells (r - 1, c - 1) and (r, c).
  void pass(float* window, const Fraction& at) {
    const float w00 = at.row * at.cell, w01 = at.row * (1 - at.cell);
    const float w10 = (1 - at.row) * at.cell, w11 = (1 - at.row) * (1 - at.cell);
    for (std::int64_t r = 0; r <= extinction_.rows; ++r) {
      const float* const __restrict before = padded_.data() + r * padded_stride_;
      const float* const __restrict behind = before + padded_stride_;
      float* const __restrict light = window + r * stride_;
      for (std::int64_t c = 0; c <= extinction_.cells; ++c) {
        const float depth = absorption_ * (w00 * before[c] + w01 * before[c + 1] + w10 * behind[c] +
                                           w11 * behind[c + 1]);
        const float through = attenuation(depth + regain_);
        // The light that it would settle at, of a medium without end.
        const float settled = regain_ / (depth + regain_ + 1e-30F);
        light[c] = light[c] * through + settled * (1 - through);
      }
    }
  }

  const Reordered& extinction_;
  const CrossedSlices& crossed_;
  Reordered& sum_;
  bool is_from_end_;
  float weight_, absorption_, regain_;
  float per_length_;               // slices
  std::array<float, 3> step_;      // of a ray to the next slice, in slices, rows and cells
  double row_drift_, cell_drift_;  // of a ray, from slice to slice, against the light
  std::int64_t first_row_, first_cell_, stride_, padded_stride_;
  std::vector<float> light_;   // of the columns
  std::vector<float> padded_;  // a slice's extinction
};

int steepest_axis(const Vec3& direction) {
  int axis = 0;
  direction.cwiseAbs().maxCoeff(&axis);
  return axis;
}

}  // namespace

std::vector<float> mean_arriving_light(const ExtinctionLattice& lattice,
                                       const std::vector<Vec3>& towards_light, const LightWay& way,
                                       int threads, const std::stop_token& stop) {
  const Mat3 cells_per_length = lattice.world_from_cell.linear().inverse();
  const float weight = 1.0F / static_cast<float>(towards_light.size());
  const auto threads_at_most = static_cast<std::size_t>(data::resolve_threads(threads));
  std::vector<float> mean(lattice.extinction.size(), 0.0F);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::array<std::vector<Vec3>, kHands> dealt;
    std::size_t next = 0;
    for (const Vec3& towards : towards_light) {
      const Vec3 in_cells = cells_per_length * towards;
      if (steepest_axis(in_cells) == static_cast<int>(axis))
        dealt[next++ % kHands].push_back(in_cells);
    }
    if (next == 0) continue;
    const SweepAxes& axes = kSweepAxes[axis];
    Reordered extinction(lattice.dims, axes);
    for_each_cell(extinction, lattice.dims, [&](std::size_t to, std::size_t from) {
      extinction.values[to] = lattice.extinction[from];
    });
    const CrossedSlices crossed(lattice.crossed, axes, extinction.slices);
    const std::size_t hands = std::min(next, kHands);
    std::vector<Reordered> sums;
    const std::size_t at_once = std::min(hands, threads_at_most);
    sums.reserve(at_once);
    while (sums.size() < at_once) sums.emplace_back(lattice.dims, axes);
    for (std::size_t first = 0; first < hands; first += at_once) {
      const std::size_t count = std::min(at_once, hands - first);
      data::parallel_ranges({static_cast<std::int64_t>(count), 1, threads, stop},
                            [&](std::int64_t hand, std::int64_t) {
                              const auto h = static_cast<std::size_t>(hand);
                              std::fill(sums[h].values.begin(), sums[h].values.end(), 0.0F);
                              for (const Vec3& direction : dealt[first + h]) {
                                if (stop.stop_requested()) return;
                                Sweep(extinction, crossed, direction, way, weight, sums[h]).run();
                              }
                            });
      for (std::size_t h = 0; h < count; ++h) {
        for_each_cell(sums[h], lattice.dims,
                      [&](std::size_t from, std::size_t to) { mean[to] += sums[h].values[from]; });
      }
    }
  }
  return mean;
}

std::vector<Vec3> directions_of_sphere(int count) {
  std::vector<Vec3> directions;
  const int half = count / 2;
  for (int i = 0; i < half; ++i) {
    const double z = (i + 0.5) / half;
    const double turn = 2 * std::numbers::pi * (std::numbers::phi - 1) * i;
    const double radius = std::sqrt(1 - z * z);
    const Vec3 direction(radius * std::cos(turn), radius * std::sin(turn), z);
    directions.push_back(direction);
    directions.push_back(-direction);
  }
  return directions;
}

std::vector<Vec3> directions_of_cone(const Vec3& axis, double angle, int count) {
  const Vec3 other = std::abs(axis[0]) < 0.9 ? Vec3::UnitX() : Vec3::UnitY();
  const Vec3 right = axis.cross(other).normalized();
  const Vec3 up = right.cross(axis);
  std::vector<Vec3> directions;
  for (int i = 0; i < count; ++i) {
    const double along = 1 - (1 - std::cos(angle)) * (i + 0.5) / count;
    const double turn = 2 * std::numbers::pi * (std::numbers::phi - 1) * i;
    const double radius = std::sqrt(1 - along * along);
    directions.push_back(along * axis + radius * (std::cos(turn) * right + std::sin(turn) * up));
  }
  return directions;
}

}  // namespace ovoid
