// SPDX-License-Identifier: Apache-2.0
#include "ovoid/crop.h"

#include <fmt/format.h>

#include <cmath>

#include "ovoid/error.h"

namespace ovoid {
namespace {

constexpr const char* kIndexNames[] = {"i", "j", "k"};
constexpr const char* kWorldNames[] = {"x", "y", "z"};

// Axes that deviate less from the world's are parallel to them.
constexpr double kParallelSine = 1e-9;

[[noreturn]] void refuse_crop(const std::string& message) {
  throw Error(ErrorCode::kInvalidArgument, message);
}

void require_within(const LatticeGeometry& geometry, const Index3& lo, const Index3& hi) {
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int64_t last = geometry.dims[a] - 1;
    if (lo[a] > hi[a]) {
      refuse_crop(fmt::format("crop {} = {}:{}: must not be empty", kIndexNames[a], lo[a], hi[a]));
    }
    if (lo[a] < 0 || hi[a] > last) {
      refuse_crop(fmt::format("crop {} = {}:{}: must lie within the data's samples 0 to {}",
                              kIndexNames[a], lo[a], hi[a], last));
    }
  }
}

void require_not_empty(const Bounds3& world) {
  for (int a = 0; a < 3; ++a) {
    if (!(world.min()[a] < world.max()[a])) {
      refuse_crop(fmt::format("crop-world {} = {}:{}: must not be empty", kWorldNames[a],
                              world.min()[a], world.max()[a]));
    }
  }
}

bool is_parallel_to_world(const LatticeGeometry& geometry) {
  const Mat3 axes = geometry.world_from_index.linear().colwise().normalized();
  for (int a = 0; a < 3; ++a) {
    if (1 - axes.col(a).cwiseAbs().maxCoeff() > kParallelSine * kParallelSine) return false;
  }
  return true;
}

}  // namespace

Bounds3 Box::world_bounds() const {
  Bounds3 world;
  for (int corner = 0; corner < 8; ++corner) {
    world.extend(world_from_box * bounds.corner(static_cast<Bounds3::CornerType>(corner)));
  }
  return world;
}

Box box_of(const LatticeGeometry& geometry) {
  return {geometry.world_from_index, geometry.index_bounds()};
}

std::vector<ClipPlane> crop_planes(const LatticeGeometry& geometry, const Index3& lo,
                                   const Index3& hi) {
  require_within(geometry, lo, hi);
  // Index u_a = row_a (p - t): u_a >= b is the half space row_a p >= b + row_a t.
  const Mat3 index_from_world = geometry.world_from_index.linear().inverse();
  const Vec3 origin = geometry.world_from_index.translation();
  const Bounds3 kept = geometry.index_bounds(lo, hi);
  std::vector<ClipPlane> planes;
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<std::size_t>(a);
    const Vec3 normal = index_from_world.row(a).transpose();
    const double at_origin = normal.dot(origin);
    if (lo[i] > 0) planes.push_back({normal, at_origin + kept.min()[a]});
    if (hi[i] < geometry.dims[i] - 1) planes.push_back({-normal, -(at_origin + kept.max()[a])});
  }
  return planes;
}

std::vector<ClipPlane> crop_planes(const Bounds3& world) {
  require_not_empty(world);
  std::vector<ClipPlane> planes;
  for (int a = 0; a < 3; ++a) {
    const Vec3 normal = Vec3::Unit(a);
    if (std::isfinite(world.min()[a])) planes.push_back({normal, world.min()[a]});
    if (std::isfinite(world.max()[a])) planes.push_back({-normal, -world.max()[a]});
  }
  return planes;
}

std::array<ClipPlane, 2> slice_planes(const ClipPlane& middle, double thickness) {
  const double length = middle.normal.norm();
  if (!middle.normal.allFinite() || !std::isfinite(length) || !(length > 0))
    refuse_crop("slice normal: must be finite and have a length");
  if (!std::isfinite(middle.offset)) refuse_crop("slice offset: must be finite");
  if (!std::isfinite(thickness) || !(thickness > 0))
    refuse_crop(fmt::format("slice thickness = {}: must be > 0 and finite", thickness));
  const Vec3 normal = middle.normal / length;
  const double offset = middle.offset / length;
  return {ClipPlane{normal, offset - 0.5 * thickness},
          ClipPlane{-normal, -offset - 0.5 * thickness}};
}

Box crop_box(const LatticeGeometry& geometry, const Index3& lo, const Index3& hi) {
  require_within(geometry, lo, hi);
  return {geometry.world_from_index, geometry.index_bounds(lo, hi)};
}

Box crop_box(const Bounds3& bounds, const Bounds3& world) {
  require_not_empty(world);
  const Bounds3 common = bounds.intersection(world);
  for (int a = 0; a < 3; ++a) {
    if (common.min()[a] < common.max()[a]) continue;
    refuse_crop(fmt::format("crop-world {} = {}:{}: must meet the data, which lies from {} to {}",
                            kWorldNames[a], world.min()[a], world.max()[a], bounds.min()[a],
                            bounds.max()[a]));
  }
  return {Affine3::Identity(), common};
}

Box crop_box(const LatticeGeometry& geometry, const Bounds3& world) {
  Box in_world = crop_box(geometry.world_bounds(), world);
  const Bounds3& common = in_world.bounds;
  if (!is_parallel_to_world(geometry)) return in_world;
  // In the lattice's own axes: they may be permuted or turned round.
  const Affine3 index_from_world = geometry.world_from_index.inverse();
  Box box{geometry.world_from_index, {}};
  box.bounds.extend(index_from_world * common.min());
  box.bounds.extend(index_from_world * common.max());
  return box;
}

}  // namespace ovoid
