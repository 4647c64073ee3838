// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "ovoid/math.h"
#include "view.h"

namespace ovoid::mappers {

// Rays through the pixels' centres, by distance along the view axis.
class Rays {
 public:
  explicit Rays(const View& view) : view_(view) {
    const Camera& camera = view.camera;
    ahead_ = (camera.focal_point - camera.position).normalized();
    right_ = ahead_.cross(camera.view_up).normalized();
    up_ = right_.cross(ahead_);
    constexpr double kRadians = 3.14159265358979323846 / 180;
    const double half = camera.parallel_projection ? camera.parallel_scale
                                                   : std::tan(0.5 * kRadians * camera.view_angle);
    pixel_ = 2 * half / view.height;
  }

  // Row 0 at the top.
  void at(int x, int y, Vec3* origin, Vec3* direction) const {
    const Vec3 aside =
        pixel_ * ((x + 0.5 - 0.5 * view_.width) * right_ + (0.5 * view_.height - y - 0.5) * up_);
    *origin = view_.camera.position;
    *direction = ahead_;
    (view_.camera.parallel_projection ? *origin : *direction) += aside;
  }

 private:
  const View& view_;
  Vec3 ahead_, right_, up_;
  double pixel_ = 0;
};

}  // namespace ovoid::mappers
