// SPDX-License-Identifier: Apache-2.0
#include "projection.h"

#include <cmath>
#include <numbers>

namespace ovoid::viewer {

Projection::Projection(const Camera& camera, double width, double height)
    : position_(camera.position),
      is_parallel_(camera.parallel_projection),
      focal_depth_((camera.focal_point - camera.position).norm()),
      middle_(width / 2, height / 2) {
  forward_ = (camera.focal_point - camera.position).normalized();
  right_ = forward_.cross(camera.view_up).normalized();
  up_ = right_.cross(forward_);
  const double half = is_parallel_
                          ? camera.parallel_scale
                          : focal_depth_ * std::tan(camera.view_angle * std::numbers::pi / 360);
  focal_pixel_ = 2 * half / height;
}

double Projection::depth_of(const Vec3& world) const { return (world - position_).dot(forward_); }

double Projection::pixel_size_at(double depth) const {
  return is_parallel_ ? focal_pixel_ : focal_pixel_ * depth / focal_depth_;
}

std::optional<Vec2> Projection::pixel_of(const Vec3& world) const {
  const double depth = depth_of(world);
  constexpr double kNearest = 1e-6;  // of the way to the focal point
  if (!is_parallel_ && depth < kNearest * focal_depth_) return std::nullopt;
  const double size = pixel_size_at(depth);
  const Vec3 offset = world - position_;
  return middle_ + Vec2(offset.dot(right_), -offset.dot(up_)) / size;
}

Vec3 Projection::world_at(const Vec2& pixel, double depth) const {
  const Vec2 offset = (pixel - middle_) * pixel_size_at(depth);
  return position_ + forward_ * depth + right_ * offset.x() - up_ * offset.y();
}

Vec3 Projection::ray_origin(const Vec2& pixel) const {
  return is_parallel_ ? world_at(pixel, 0) : position_;
}

Vec3 Projection::ray_direction(const Vec2& pixel) const {
  if (is_parallel_) return forward_;
  return (world_at(pixel, focal_depth_) - position_).normalized();
}

Camera of_height(Camera camera, double factor) {
  camera.parallel_scale *= factor;
  constexpr double kHalfDegree = std::numbers::pi / 360;
  camera.view_angle = std::atan(std::tan(camera.view_angle * kHalfDegree) * factor) / kHalfDegree;
  return camera;
}

}  // namespace ovoid::viewer
