// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "ovoid/camera.h"
#include "ovoid/math.h"

namespace ovoid::viewer {

using Vec2 = Eigen::Vector2d;

// Between the world and a picture's pixels: x to the right and y downwards from the upper left
// corner, pixel centres at +0.5; depth along the view axis from the camera's plane, world units.
class Projection {
 public:
  Projection(const Camera& camera, double width, double height);  // pixels

  // Empty for what lies behind a perspective's eye.
  std::optional<Vec2> pixel_of(const Vec3& world) const;
  double depth_of(const Vec3& world) const;
  Vec3 world_at(const Vec2& pixel, double depth) const;
  double focal_depth() const noexcept { return focal_depth_; }
  double pixel_size_at(double depth) const;  // world units

  // From the eye, or with parallel projection from the camera's plane; unit length.
  Vec3 ray_direction(const Vec2& pixel) const;
  Vec3 ray_origin(const Vec2& pixel) const;

  const Vec3& right() const noexcept { return right_; }
  const Vec3& up() const noexcept { return up_; }
  const Vec3& forward() const noexcept { return forward_; }

 private:
  Vec3 position_, right_, up_, forward_;
  bool is_parallel_;
  double focal_depth_;
  double focal_pixel_;  // world size of a pixel at the focal plane
  Vec2 middle_;
};

// A camera for a picture that is `factor` times as high, or a piece of one: the world is as large
// in its pixels.
Camera of_height(Camera camera, double factor);

}  // namespace ovoid::viewer
