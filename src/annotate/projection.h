// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <utility>

#include "annotate/font.h"
#include "ovoid/camera.h"

namespace ovoid::annotate {

// From the world to the picture, as the view lattice has it (docs/numerics.md), for lines.
class Projection {
 public:
  Projection(const Camera& camera, int width, int height);  // throws Error for an invalid camera

  // Along right, up and the view axis.
  Vec3 turned(const Vec3& direction) const;
  // Depth of a point: distance from the camera plane along the view axis.
  double depth(const Vec3& world) const;
  // From a point towards the eye.
  Vec3 towards_eye(const Vec3& world) const;

  // Pixels of a line's ends, cut at the near plane; none if all of it lies behind.
  std::optional<std::pair<Vec2, Vec2>> line(Vec3 a, Vec3 b) const;

  double pixels_per_world_at_focus() const;

 private:
  Vec2 pixel(const Vec3& world) const;

  Vec3 position_, right_, up_, axis_;
  bool is_parallel_;
  double focal_depth_, near_depth_;
  double half_height_;  // parallel: world; perspective: tangent of half the view angle
  double width_, height_;
};

}  // namespace ovoid::annotate
