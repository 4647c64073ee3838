// SPDX-License-Identifier: Apache-2.0
#include "support/volumes.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace ovoid::test {

FunctionSource::FunctionSource(LatticeGeometry geometry, const VolumeFunction& function,
                               Options options)
    : geometry_(std::move(geometry)), options_(options) {
  const Index3 cells = geometry_.cells();
  for (int a = 0; a < 3; ++a) {
    num_bricks_[a] = (cells[a] + options_.brick_edge - 1) / options_.brick_edge;
  }
  for (std::int64_t bz = 0; bz < num_bricks_[2]; ++bz) {
    for (std::int64_t by = 0; by < num_bricks_[1]; ++by) {
      for (std::int64_t bx = 0; bx < num_bricks_[0]; ++bx) {
        bricks_.push_back(make_brick({bx, by, bz}, function));
      }
    }
  }
}

FunctionSource::Brick FunctionSource::make_brick(const Index3& brick,
                                                 const VolumeFunction& function) const {
  constexpr std::int64_t kMargin = 1;      // covered samples beyond the brick's own
  constexpr std::int64_t kRowPadding = 3;  // floats
  // Of several sublattices, somewhat more samples than reach the brick.
  const int num_sublattices = geometry_.num_sublattices();
  const auto reach =
      static_cast<std::int64_t>(std::floor(options_.range_reach)) + num_sublattices - 1;
  Brick result;
  BrickView& view = result.view;
  Index3 range_lo;
  Index3 range_hi;
  for (int a = 0; a < 3; ++a) {
    const std::int64_t per_cell = a == 2 ? num_sublattices : 1;
    const std::int64_t begin = brick[a] * options_.brick_edge * per_cell;
    const std::int64_t end = begin + options_.brick_edge * per_cell;
    view.lo[a] = std::max<std::int64_t>(begin - kMargin, 0);
    view.hi[a] = std::min(end + kMargin, geometry_.dims[a]);
    range_lo[a] = std::max<std::int64_t>(begin - reach * per_cell, 0);
    range_hi[a] = std::min(end + (reach + 1) * per_cell, geometry_.dims[a]);
  }
  view.stride_y = view.hi[0] - view.lo[0] + kRowPadding;
  view.stride_z = view.stride_y * (view.hi[1] - view.lo[1]) + kRowPadding;
  result.samples.assign(static_cast<std::size_t>(view.stride_z * (view.hi[2] - view.lo[2])),
                        std::numeric_limits<float>::quiet_NaN());
  for (std::int64_t k = view.lo[2]; k < view.hi[2]; ++k) {
    for (std::int64_t j = view.lo[1]; j < view.hi[1]; ++j) {
      for (std::int64_t i = view.lo[0]; i < view.hi[0]; ++i) {
        const std::int64_t at =
            (i - view.lo[0]) + (j - view.lo[1]) * view.stride_y + (k - view.lo[2]) * view.stride_z;
        result.samples[static_cast<std::size_t>(at)] = static_cast<float>(function(i, j, k));
      }
    }
  }
  view.data = result.samples.data();  // a vector's memory stays where it is when the vector moves

  for (std::int64_t k = range_lo[2]; k < range_hi[2]; ++k) {
    for (std::int64_t j = range_lo[1]; j < range_hi[1]; ++j) {
      for (std::int64_t i = range_lo[0]; i < range_hi[0]; ++i) {
        const auto number = static_cast<float>(function(i, j, k));
        if (!std::isfinite(number)) {
          result.has_missing = true;
          continue;
        }
        const auto value =
            static_cast<float>(number * options_.value_scale + options_.value_offset);
        const bool is_first = result.range.is_empty();
        result.range.lo = is_first ? value : std::min(result.range.lo, value);
        result.range.hi = is_first ? value : std::max(result.range.hi, value);
      }
    }
  }
  return result;
}

const FunctionSource::Brick& FunctionSource::brick(std::int64_t bx, std::int64_t by,
                                                   std::int64_t bz) const noexcept {
  return bricks_[static_cast<std::size_t>(bx + num_bricks_[0] * (by + num_bricks_[1] * bz))];
}

ValueRange FunctionSource::brick_range(std::int64_t bx, std::int64_t by,
                                       std::int64_t bz) const noexcept {
  return brick(bx, by, bz).range;
}

bool FunctionSource::has_missing(std::int64_t bx, std::int64_t by, std::int64_t bz) const noexcept {
  return brick(bx, by, bz).has_missing;
}

BrickView FunctionSource::acquire(std::int64_t bx, std::int64_t by, std::int64_t bz,
                                  double /*time*/) const {
  return brick(bx, by, bz).view;
}

std::size_t FunctionSource::resident_bytes() const noexcept {
  std::size_t bytes = 0;
  for (const Brick& brick : bricks_) bytes += sizeof(Brick) + brick.samples.size() * sizeof(float);
  return bytes;
}

LatticeField make_field(const Index3& dims, const VolumeFunction& function,
                        const FieldSetup& setup) {
  const LatticeGeometry lattice{dims, setup.world_from_index, setup.lattice};
  FunctionSource::Options options;
  options.brick_edge = setup.brick_edge;
  options.range_reach = setup.kernel.support_radius() * lattice.unit_spacing();
  options.value_scale = setup.value_scale;
  options.value_offset = setup.value_offset;
  auto source = std::make_shared<FunctionSource>(lattice, function, options);
  return LatticeField(std::move(source), setup.kernel, setup.reconstruction);
}

LatticeField constant_field(const Index3& dims, double value, const FieldSetup& setup) {
  return make_field(
      dims, [value](std::int64_t, std::int64_t, std::int64_t) { return value; }, setup);
}

Affine3 scaled_axes(const Vec3& spacing, const Vec3& origin) {
  return Eigen::Translation3d(origin) * Eigen::Scaling(spacing);
}

Affine3 oblique_axes() {
  Affine3 axes = Affine3::Identity();
  axes.linear().col(0) = Vec3(0.8, 0.1, -0.2);
  axes.linear().col(1) =
      Vec3(-0.5, -1.3, 0.4);  // against the right hand: the determinant is negative
  axes.linear().col(2) = Vec3(0.3, 0.6, 1.9);
  axes.translation() = Vec3(120, -45, 7);
  return axes;
}

}  // namespace ovoid::test
