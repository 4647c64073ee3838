// SPDX-License-Identifier: Apache-2.0
#include "view/view_lattice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace ovoid::view {

ViewLattice::ViewLattice(const Camera& camera, int width, int height, double sampling_distance,
                         const LatticeGeometry& lattice)
    : width_(width),
      height_(height),
      is_parallel_(camera.parallel_projection),
      sampling_distance_(sampling_distance),
      world_from_index_(lattice.world_from_index) {
  const Vec3 towards = camera.focal_point - camera.position;
  focal_depth_ = towards.norm();
  axis_ = towards / focal_depth_;
  const Vec3 right = axis_.cross(camera.view_up).normalized();
  const Vec3 up = right.cross(axis_);
  half_height_ =
      is_parallel_ ? camera.parallel_scale : std::tan(camera.view_angle * std::numbers::pi / 360.0);
  near_depth_ = is_parallel_ ? -std::numeric_limits<double>::infinity() : sampling_distance / 2;

  world_frame_ = {camera.position, right, up, axis_};
  const Affine3 index_from_world = world_from_index_.inverse();
  const Mat3 linear = index_from_world.linear();
  index_frame_ = {index_from_world * camera.position, linear * right, linear * up, linear * axis_};
}

SheetMap ViewLattice::map_at_depth(const Frame& frame, double depth) const {
  const double scale = is_parallel_ ? half_height_ : half_height_ * depth;
  const double aspect = static_cast<double>(width_) / height_;
  SheetMap map;
  map.per_x = frame.right * (2 * aspect * scale / width_);
  map.per_y = frame.up * (-2 * scale / height_);
  map.origin = frame.position + frame.axis * depth +
               frame.right * (aspect * scale * (1.0 / width_ - 1)) +
               frame.up * (scale * (1 - 1.0 / height_));
  return map;
}

double ViewLattice::pitch(std::int64_t sheet) const noexcept {
  return 2 * half_height_ * (is_parallel_ ? 1.0 : depth(sheet)) / height_;
}

SheetMap ViewLattice::ray_direction() const {
  if (is_parallel_) return {axis_, Vec3::Zero(), Vec3::Zero()};
  // Not a difference of places, in which a direction of unit length may be lost.
  auto from_eye = world_frame_;
  from_eye.position = Vec3::Zero();
  return map_at_depth(from_eye, 1.0);
}

ViewLattice::SheetRange ViewLattice::sheets_meeting(const Bounds3& index_box) const {
  double nearest = std::numeric_limits<double>::infinity();
  double farthest = -nearest;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 world =
        world_from_index_ * index_box.corner(static_cast<Bounds3::CornerType>(corner));
    const double depth = axis_.dot(world - world_frame_.position);
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
