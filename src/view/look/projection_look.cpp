// SPDX-License-Identifier: Apache-2.0
// The look of pictures that show one value of each ray: docs/looks.md, "Projections". What such a
// picture shows is far from what the data hold: of a heavy tail it is the tail. So the range is
// that of the values that rays along the axes have.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <new>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "data/kernels/kernel_shape.h"
#include "data/lattice/sample_reader.h"
#include "data/out_of_memory.h"
#include "data/validate.h"
#include "ovoid/look.h"
#include "view/look/field_samples.h"

namespace ovoid {
namespace {

using view::quantile;

// Of ranges or values on the way of one ray.
class RayValue {
 public:
  void add(double lo, double hi) {
    greatest_ = std::max(greatest_, hi);
    least_ = std::min(least_, lo);
    sum_ += 0.5 * (lo + hi);
    ++count_;
  }
  // None: the ray meets nothing.
  std::optional<float> in(Mode mode) const {
    if (count_ == 0) return std::nullopt;
    if (mode == Mode::kMean) return static_cast<float>(sum_ / static_cast<double>(count_));
    return static_cast<float>(mode == Mode::kMinimum ? least_ : greatest_);
  }

 private:
  double greatest_ = std::numeric_limits<double>::lowest();
  double least_ = std::numeric_limits<double>::max();
  double sum_ = 0;
  std::int64_t count_ = 0;
};

void take_all(const std::vector<RayValue>& rays, Mode mode, std::vector<float>& found) {
  for (const RayValue& ray : rays)
    if (const auto one = ray.in(mode)) found.push_back(*one);
}

// Every sample.
std::vector<float> rays_through_samples(const BrickSource& source, Mode mode) {
  const Index3& dims = source.geometry().dims;
  std::array<std::vector<RayValue>, 3> views;
  for (std::size_t axis = 0; axis < 3; ++axis)
    views[axis].resize(static_cast<std::size_t>(dims[(axis + 1) % 3] * dims[(axis + 2) % 3]));
  data::SampleReader reader(source);
  Index3 at{};
  for (at[2] = 0; at[2] < dims[2]; ++at[2]) {
    for (at[1] = 0; at[1] < dims[1]; ++at[1]) {
      for (at[0] = 0; at[0] < dims[0]; ++at[0]) {
        const float value = reader.at(at);
        if (std::isnan(value)) continue;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const std::size_t across = (axis + 1) % 3, down = (axis + 2) % 3;
          views[axis][static_cast<std::size_t>(at[across] + dims[across] * at[down])].add(value,
                                                                                          value);
        }
      }
    }
  }
  std::vector<float> found;
  for (const auto& rays : views) take_all(rays, mode, found);
  return found;
}

// Along each axis at most this many by as many rays, evenly through the bricks.
constexpr std::int64_t kMostRays = 64;

std::vector<float> rays_through_bricks(const BrickSource& source, Mode mode) {
  const std::int64_t edge = source.brick_edge();
  Index3 counts{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t cells = edge * (axis == 2 ? source.geometry().num_sublattices() : 1);
    counts[axis] = (source.geometry().dims[axis] + cells - 1) / cells;
  }
  std::vector<float> found;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t across = (axis + 1) % 3, down = (axis + 2) % 3;
    const std::int64_t width = std::min(counts[across], kMostRays);
    const std::int64_t height = std::min(counts[down], kMostRays);
    for (std::int64_t ray = 0; ray < width * height; ++ray) {
      Index3 brick{};
      brick[across] = (ray % width) * counts[across] / width;
      brick[down] = (ray / width) * counts[down] / height;
      RayValue value;
      for (brick[axis] = 0; brick[axis] < counts[axis]; ++brick[axis]) {
        const ValueRange range = source.brick_range(brick[0], brick[1], brick[2]);
        if (!range.is_empty()) value.add(range.lo, range.hi);
      }
      if (const auto one = value.in(mode)) found.push_back(*one);
    }
  }
  return found;
}

// What is odd in a few samples of a small lattice would be in many of its few bricks.
std::vector<float> rays_through(const BrickSource& source, Mode mode) {
  constexpr std::int64_t kSmall = 1 << 21;
  return num_samples(source.geometry().dims) <= kSmall ? rays_through_samples(source, mode)
                                                       : rays_through_bricks(source, mode);
}

// A kernel as a ray sees it.
struct SeenKernel {
  int cell;  // of the rays that may meet it
  double value;
  double area;  // across the ray, world units squared
};

// What rays through a cell of area 1 show of kernels that lie anywhere in it, for even shares of
// them: those beyond the last meet nothing. `front`: by which all come, those that are shown first.
void add_shown(std::span<const SeenKernel> front, double scale, std::vector<float>& found) {
  constexpr int kShares = 8;
  double covered = 0;  // -log of the share of rays that none so far meets
  std::size_t next = 0;
  for (int share = 0; share < kShares; ++share) {
    const double wanted = -std::log1p(-(share + 0.5) / kShares);
    while (next < front.size() && covered < wanted) covered += scale * front[next++].area;
    if (covered < wanted) return;
    found.push_back(static_cast<float>(front[next - 1].value));
  }
}

// Some thousands of kernels, each with the field's value at its centre, or its own where these are
// averages.
struct SomeKernels {
  std::vector<Vec3> places;
  std::vector<double> values, areas;
  double stand_for = 1;  // so many each
};

SomeKernels some_kernels(const KernelField& field) {
  constexpr std::int64_t kWanted = 4096;
  const KernelSource& source = field.source();
  SomeKernels some;
  view::for_values_at_kernels(
      field, kWanted,
      [&](const KernelBrick& brick, const KernelView& view, std::int32_t i, float value) {
        if (!std::isfinite(value)) return;
        const std::array<float, 6> shape = data::shape_numbers(view, source.shape(), i);
        const double volume = std::abs(data::factor_of(source.shape(), shape.data()).determinant());
        some.places.push_back(brick.origin + data::offset_of(view, i));
        some.values.push_back(value);
        some.areas.push_back(std::numbers::pi * std::pow(volume, 2.0 / 3));
      });
  some.stand_for = static_cast<double>(source.num_kernels()) /
                   static_cast<double>(std::max<std::size_t>(1, some.places.size()));
  return some;
}

// The view along each axis is cut into cells, within which kernels are taken to lie anywhere.
std::vector<float> rays_through(const KernelField& field, Mode mode) {
  constexpr int kCells = 24;  // along an edge
  const SomeKernels some = some_kernels(field);
  const Bounds3 box = field.world_bounds();
  const Vec3 sizes = box.sizes().cwiseMax(1e-12 * box.sizes().maxCoeff() + 1e-300);
  const auto cell_along = [&](std::size_t i, Eigen::Index axis) {
    const double along = kCells * (some.places[i][axis] - box.min()[axis]) / sizes[axis];
    return static_cast<int>(std::clamp(along, 0.0, kCells - 0.5));
  };
  std::vector<float> found;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Eigen::Index across = (axis + 1) % 3, down = (axis + 2) % 3;
    std::vector<SeenKernel> seen;
    for (std::size_t i = 0; i < some.places.size(); ++i)
      seen.push_back(
          {cell_along(i, across) + kCells * cell_along(i, down), some.values[i], some.areas[i]});
    const double sign = mode == Mode::kMinimum ? -1 : 1;
    std::sort(seen.begin(), seen.end(), [&](const SeenKernel& a, const SeenKernel& b) {
      return a.cell != b.cell ? a.cell < b.cell : sign * a.value > sign * b.value;
    });
    const double scale = some.stand_for * kCells * kCells / (sizes[across] * sizes[down]);
    for (auto first = seen.begin(); first != seen.end();) {
      const auto end = std::find_if(
          first, seen.end(), [&](const SeenKernel& kernel) { return kernel.cell != first->cell; });
      if (mode == Mode::kMean) {
        RayValue value;
        for (auto one = first; one != end; ++one) value.add(one->value, one->value);
        found.push_back(*value.in(mode));
      } else {
        add_shown({first, end}, scale, found);
      }
      first = end;
    }
  }
  return found;
}

// Where rays end that miss what there is to see, all have nearly one value. Those are left out.
void leave_out_background(std::vector<float>& rising, double least) {
  constexpr double kNear = 0.02;
  constexpr std::size_t kFew = 16;
  const double near = least + kNear * (quantile(rising, 0.99) - least);
  const auto first = std::upper_bound(rising.begin(), rising.end(), static_cast<float>(near));
  if (rising.end() - first >= static_cast<std::ptrdiff_t>(kFew))
    rising.erase(rising.begin(), first);
}

// Whether the values go over decades, so that most rays would be dark. `least`: what nearly all of
// them are above, as a share of the median.
bool spans_decades(std::span<const float> rising, double quotient, double least) {
  const double low = quantile(rising, 0.02), middle = quantile(rising, 0.5);
  return low > 0 && low > least * middle && quantile(rising, 0.98) > quotient * middle;
}

// The rays that matter, and whether a logarithm shows them better. Kernels are where something is,
// so that none of them is a background; of samples one may be, unless they are densities.
bool take_rays(std::vector<float>& rising, bool is_lattice, double background) {
  constexpr double kDark = 30, kOfDensities = 1000, kLeastDensity = 0.01;
  if (!is_lattice) return spans_decades(rising, kDark, 0);
  if (spans_decades(rising, kOfDensities, kLeastDensity)) return true;
  leave_out_background(rising, background);
  return spans_decades(rising, kDark, kLeastDensity);
}

}  // namespace

Look projection_look(const Field& field, Mode mode, const std::string& color_map_name) try {
  data::require_field(field);
  const ValueRange all = field.value_range();
  std::vector<float> rays = field.lattice() != nullptr
                                ? rays_through(field.lattice()->samples(), mode)
                                : rays_through(*field.kernels(), mode);
  if (all.is_empty() || all.lo == all.hi || rays.empty()) return ramp_look(all, color_map_name);
  std::sort(rays.begin(), rays.end());
  const bool is_wide =
      take_rays(rays, field.lattice() != nullptr && mode != Mode::kMinimum, all.lo);
  const double low = quantile(rays, 0.02), high = quantile(rays, 0.98);
  if (is_wide) {
    constexpr double kDecades = 1e-4;
    Look look = ramp_look({0, 1}, color_map_name);
    look.transfer_function.map_range(std::max(0.5 * low, kDecades * high), high, ValueScale::kLog);
    return look;
  }
  // What is least of what is seen is still seen.
  constexpr double kBelow = 0.15;
  const double lo = std::max<double>(all.lo, low - kBelow * (high - low));
  if (!(high > lo)) return ramp_look(all, color_map_name);
  return ramp_look({static_cast<float>(lo), static_cast<float>(high)}, color_map_name);
} catch (const std::bad_alloc&) {
  data::throw_out_of_memory("the values of rays, to choose a look",
                            3 * kMostRays * kMostRays * sizeof(float));
}

}  // namespace ovoid
