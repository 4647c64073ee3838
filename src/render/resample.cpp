// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <new>
#include <span>
#include <utility>

#include "data/parallel.h"
#include "data/validate.h"
#include "ovoid/error.h"
#include "ovoid/sampler.h"

namespace ovoid {
namespace {

[[noreturn]] void refuse_lattice(const std::string& message) {
  throw Error(ErrorCode::kInvalidArgument, message);
}

Vec3 sides_of(const Bounds3& bounds) {
  if (bounds.isEmpty() || !bounds.sizes().allFinite() || !(bounds.sizes().minCoeff() > 0))
    refuse_lattice("bounds: must be finite and have a volume");
  return bounds.sizes();
}

void require_side(std::int64_t side, int axis) {
  if (side >= 1 && side <= kMaxLatticeSide) return;
  refuse_lattice(fmt::format("size[{}] = {}: must be 1 to {}", axis, side, kMaxLatticeSide));
}

std::shared_ptr<float[]> floats(std::int64_t count) {
  return std::make_shared_for_overwrite<float[]>(static_cast<std::size_t>(count));
}

DataArray array_of_floats(const std::string& name, std::shared_ptr<float[]> values,
                          std::int64_t count) {
  DataArray array;
  array.name = name;
  array.num_tuples = count;
  const std::span<const float> view(values.get(), static_cast<std::size_t>(count));
  array.bytes = {std::move(values), std::as_bytes(view)};
  return array;
}

// Tells how many rows are done, in order.
class RowCount {
 public:
  RowCount(const std::function<void(double)>& progress, std::int64_t total)
      : progress_(progress), total_(total) {}

  void add() {
    if (!progress_) return;
    const std::scoped_lock lock(mutex_);
    progress_(static_cast<double>(++done_) / static_cast<double>(total_));
  }

 private:
  const std::function<void(double)>& progress_;
  const std::int64_t total_;
  std::int64_t done_ = 0;
  std::mutex mutex_;
};

}  // namespace

LatticeGeometry lattice_over(const Bounds3& bounds, const Index3& dims) {
  Vec3 spacing = sides_of(bounds);
  for (int a = 0; a < 3; ++a) {
    require_side(dims[static_cast<std::size_t>(a)], a);
    spacing[a] /= static_cast<double>(dims[static_cast<std::size_t>(a)]);
  }
  LatticeGeometry lattice;
  lattice.dims = dims;
  lattice.world_from_index =
      Eigen::Translation3d(bounds.min() + 0.5 * spacing) * Eigen::Scaling(spacing);
  return lattice;
}

LatticeGeometry lattice_of_cubes(const Bounds3& bounds, std::int64_t longest) {
  const Vec3 sides = sides_of(bounds);
  require_side(longest, 0);
  const double edge = sides.maxCoeff() / static_cast<double>(longest);
  // A side that is a whole number of cubes but for rounding takes no further one.
  constexpr double kRounding = 1e-9;
  Index3 dims;
  Vec3 cells;
  for (int a = 0; a < 3; ++a) {
    cells[a] = std::max(1.0, std::ceil(sides[a] / edge * (1 - kRounding)));
    dims[static_cast<std::size_t>(a)] = static_cast<std::int64_t>(cells[a]);
  }
  const Vec3 half = 0.5 * edge * cells;
  return lattice_over({bounds.center() - half, bounds.center() + half}, dims);
}

Dataset resample(const Field& field, const LatticeGeometry& lattice,
                 const ResampleOptions& options) {
  data::require_field(field);
  data::validate_geometry(lattice);
  const Index3& dims = lattice.dims;
  const std::int64_t count = num_samples(dims);
  std::shared_ptr<float[]> values, colors;
  try {
    values = floats(count);
    if (!options.color_name.empty()) colors = floats(count);
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kOutOfMemory,
                fmt::format("size = {} x {} x {}: no memory for {} samples", dims[0], dims[1],
                            dims[2], count));
  }
  const FieldSampler sampler(field);
  const std::int64_t num_rows = dims[1] * dims[2];
  RowCount done(options.progress, num_rows);
  data::parallel_ranges(
      {num_rows, 1, options.threads, options.stop}, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t row = begin; row < end; ++row) {
          const std::int64_t layer = row / dims[1];
          const std::int64_t y = row - layer * dims[1];
          for (std::int64_t x = 0; x < dims[0]; ++x) {
            const FieldSample at =
                sampler.at(lattice.world_from_index * lattice.index_position({x, y, layer}));
            constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
            const std::int64_t i = row * dims[0] + x;
            values[i] = at.is_defined ? static_cast<float>(at.value) : kNone;
            if (colors) colors[i] = at.is_defined ? static_cast<float>(at.color_value) : kNone;
          }
          done.add();
        }
      });
  Dataset dataset;
  dataset.format = "resampled";
  dataset.lattice = lattice;
  dataset.arrays.push_back(array_of_floats(options.name, std::move(values), count));
  if (colors)
    dataset.arrays.push_back(array_of_floats(options.color_name, std::move(colors), count));
  return dataset;
}

}  // namespace ovoid
