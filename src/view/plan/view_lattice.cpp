// SPDX-License-Identifier: Apache-2.0
#include "view/plan/view_lattice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace ovoid::view {

namespace {

Affine3 ordered(const Affine3& world_from_index, const AxisOrder& order) {
  Affine3 out = world_from_index;
  for (int a = 0; a < 3; ++a)
    out.linear().col(a) = world_from_index.linear().col(order[static_cast<std::size_t>(a)]);
  return out;
}

}  // namespace

ViewLattice::ViewLattice(const Frame& world, const Camera& camera, int width, int height,
                         double sampling_distance, const Affine3& world_from_index)
    : width_(width),
      height_(height),
      is_parallel_(camera.parallel_projection),
      sampling_distance_(sampling_distance),
      near_depth_(is_parallel_ ? -std::numeric_limits<double>::infinity() : sampling_distance / 2),
      focal_depth_((camera.focal_point - camera.position).norm()),
      world_frame_(world),
      pitch_(std::max(world.per_x.norm(), world.per_y.norm())),
      world_from_index_(world_from_index) {
  const Vec3 across = world.per_x.cross(world.per_y);
  normal_ = across / across.dot(world.axis);
  const Affine3 index_from_world = world_from_index_.inverse();
  const Mat3 linear = index_from_world.linear();
  index_frame_ = {index_from_world * world.eye, linear * world.axis, linear * world.corner,
                  linear * world.per_x, linear * world.per_y};
}

ViewLattice::ViewLattice(const Camera& camera, int width, int height, double sampling_distance,
                         const LatticeGeometry& lattice)
    : ViewLattice(
          [&]() -> Frame {
            const Vec3 axis = (camera.focal_point - camera.position).normalized();
            const Vec3 right = axis.cross(camera.view_up).normalized();
            const Vec3 up = right.cross(axis);
            const double half = camera.parallel_projection
                                    ? camera.parallel_scale
                                    : std::tan(camera.view_angle * std::numbers::pi / 360.0);
            const double pixel = 2 * half / height;
            return {camera.position, axis,
                    right * (pixel / 2 * (1 - width)) + up * (pixel / 2 * (height - 1)),
                    right * pixel, up * -pixel};
          }(),
          camera, width, height, sampling_distance, lattice.world_from_index) {}

ViewLattice::ViewLattice(const BasePlane& base, const Camera& camera, double sampling_distance,
                         const LatticeGeometry& lattice)
    : ViewLattice(Frame{base.eye, base.axis, base.corner, base.per_x, base.per_y}, camera,
                  base.width, base.height, sampling_distance,
                  ordered(lattice.world_from_index, base.order)) {}

SheetMap ViewLattice::map_at_depth(const Frame& frame, double depth) const {
  const double scale = is_parallel_ ? 1.0 : depth;
  return {frame.eye + frame.axis * depth + frame.corner * scale, frame.per_x * scale,
          frame.per_y * scale};
}

double ViewLattice::pitch(std::int64_t sheet) const noexcept {
  return pitch_ * (is_parallel_ ? 1.0 : depth(sheet));
}

SheetMap ViewLattice::ray_direction() const {
  if (is_parallel_) return {world_frame_.axis, Vec3::Zero(), Vec3::Zero()};
  // Not a difference of places, in which a direction of unit length may be lost.
  auto from_eye = world_frame_;
  from_eye.eye = Vec3::Zero();
  return map_at_depth(from_eye, 1.0);
}

ViewLattice::SheetRange ViewLattice::sheets_meeting(const Bounds3& index_box) const {
  double nearest = std::numeric_limits<double>::infinity();
  double farthest = -nearest;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 world =
        world_from_index_ * index_box.corner(static_cast<Bounds3::CornerType>(corner));
    const double depth = normal_.dot(world - world_frame_.eye);
    nearest = std::min(nearest, depth);
    farthest = std::max(farthest, depth);
  }
  nearest = std::max(nearest, near_depth_);
  if (!(nearest <= farthest)) return {};
  const double first = std::floor((nearest - focal_depth_) / sampling_distance_ - 0.5);
  const double last = std::ceil((farthest - focal_depth_) / sampling_distance_ - 0.5) + 1;
  // Beyond this numbers of sheets are not exact; whoever counts them finds too many.
  constexpr std::int64_t kMost = std::int64_t{1} << 52;
  if (!(first > -kMost && last < kMost)) return {-kMost, kMost};
  SheetRange range{static_cast<std::int64_t>(first), static_cast<std::int64_t>(last)};
  while (range.first < range.last && depth(range.first) <= near_depth_) ++range.first;
  return range;
}

}  // namespace ovoid::view
