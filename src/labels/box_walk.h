// SPDX-License-Identifier: Apache-2.0
// From box to box of a regular grid along a ray.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "labels/label_rays.h"

namespace ovoid::labels {

// A ray's slopes, for walks along it.
struct RaySlopes {
  explicit RaySlopes(const LabelRay& ray) : origin(ray.origin), direction(ray.direction) {
    for (int a = 0; a < 3; ++a) {
      const double d = direction[a];
      inverse[a] = d == 0 ? std::numeric_limits<double>::infinity() : 1 / d;
      forward[static_cast<std::size_t>(a)] = d == 0 ? 0 : d > 0 ? 1 : -1;
    }
  }

  Vec3 origin, direction, inverse;
  std::array<int, 3> forward{};
};

class BoxWalk {
 public:
  // Boxes of `edge` from `corner` on; `num` along each axis. The place at `begin` is in one, but
  // for rounding.
  BoxWalk(const RaySlopes& ray, double begin, const Vec3& corner, int edge,
          const std::array<int, 3>& num)
      : forward_(ray.forward), num_(num), enter_(begin) {
    const double per_edge = 1.0 / edge;
    for (int a = 0; a < 3; ++a) {
      const auto i = static_cast<std::size_t>(a);
      const double place = (ray.origin[a] + begin * ray.direction[a] - corner[a]) * per_edge;
      box[i] = std::clamp(static_cast<int>(place), 0, num[i] - 1);
      if (forward_[i] == 0) {
        next_[i] = std::numeric_limits<double>::infinity();
        continue;
      }
      const auto side = static_cast<double>(edge * (box[i] + (forward_[i] > 0 ? 1 : 0)));
      next_[i] = (corner[a] + side - ray.origin[a]) * ray.inverse[a];
      step_[i] = edge * std::abs(ray.inverse[a]);
    }
    find_leave();
  }

  double enter() const { return enter_; }
  double leave() const { return std::max(enter_, leave_); }
  // Where the ray leaves all boxes that are at most so many steps away, a little before: in the
  // last of them.
  double leave_after(int steps) const {
    double leave = std::numeric_limits<double>::infinity();
    for (std::size_t a = 0; a < 3; ++a)
      leave = std::min(leave, next_[a] + (steps - kBack) * step_[a]);
    return std::max(leave, enter_);
  }
  // Returns false if there is no next box.
  bool advance() {
    enter_ = leave();
    box[axis_] += forward_[axis_];
    if (box[axis_] < 0 || box[axis_] >= num_[axis_]) return false;
    next_[axis_] += step_[axis_];
    find_leave();
    return true;
  }

  std::array<int, 3> box{};

 private:
  static constexpr double kBack = 1e-6;  // more than rounding, of a box's edge

  void find_leave() {
    axis_ = next_[0] < next_[1] ? (next_[0] < next_[2] ? 0 : 2) : (next_[1] < next_[2] ? 1 : 2);
    leave_ = next_[axis_];
  }

  std::array<double, 3> next_{}, step_{};
  std::array<int, 3> forward_;
  std::array<int, 3> num_;
  std::size_t axis_ = 0;
  double enter_, leave_ = 0;
};

}  // namespace ovoid::labels
