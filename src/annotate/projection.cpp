// SPDX-License-Identifier: Apache-2.0
#include "annotate/projection.h"

#include <cmath>
#include <numbers>

namespace ovoid::annotate {
namespace {

// Of the focal distance: nearer to the eye lines are cut. A thousandth is far inside any volume
// that is looked at, and keeps pixel coordinates small.
constexpr double kNear = 1e-3;

}  // namespace

Projection::Projection(const Camera& camera, int width, int height)
    : is_parallel_(camera.parallel_projection), width_(width), height_(height) {
  camera.validate();
  position_ = camera.position;
  const Vec3 towards = camera.focal_point - camera.position;
  focal_depth_ = towards.norm();
  axis_ = towards / focal_depth_;
  right_ = axis_.cross(camera.view_up).normalized();
  up_ = right_.cross(axis_);
  near_depth_ = kNear * focal_depth_;
  half_height_ =
      is_parallel_ ? camera.parallel_scale : std::tan(camera.view_angle * std::numbers::pi / 360);
}

Vec3 Projection::turned(const Vec3& direction) const {
  return {direction.dot(right_), direction.dot(up_), direction.dot(axis_)};
}

double Projection::depth(const Vec3& world) const { return axis_.dot(world - position_); }

Vec3 Projection::towards_eye(const Vec3& world) const {
  return is_parallel_ ? -axis_ : Vec3(position_ - world);
}

Vec2 Projection::pixel(const Vec3& world) const {
  const Vec3 view = turned(world - position_);
  const double scale = height_ / (2 * half_height_ * (is_parallel_ ? 1.0 : view.z()));
  return {width_ / 2 + view.x() * scale, height_ / 2 - view.y() * scale};
}

std::optional<std::pair<Vec2, Vec2>> Projection::line(Vec3 a, Vec3 b) const {
  if (!is_parallel_) {
    const double depth_a = depth(a);
    const double depth_b = depth(b);
    if (depth_a < near_depth_ && depth_b < near_depth_) return std::nullopt;
    const Vec3 cut = a + (near_depth_ - depth_a) / (depth_b - depth_a) * (b - a);
    if (depth_a < near_depth_) a = cut;
    if (depth_b < near_depth_) b = cut;
  }
  return std::pair{pixel(a), pixel(b)};
}

double Projection::pixels_per_world_at_focus() const {
  return height_ / (2 * half_height_ * (is_parallel_ ? 1.0 : focal_depth_));
}

}  // namespace ovoid::annotate
