// SPDX-License-Identifier: Apache-2.0
// A hyperplane through a lattice in space and time, and axes in it.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "ovoid/hyperslice.h"
#include "ovoid/lattice.h"
#include "ovoid/math.h"

namespace ovoid::model {

using Vec4 = Eigen::Vector4d;

// A lattice in space and time, in units of its T: sample (i, j, k) of step l is at `scale` times
// (i, j, k), plus `scale` / 2 along each axis in odd steps of a staggered series, and at time
// l * step_distance.
struct SpaceTime {
  SeriesKind kind;
  Index3 dims;    // of a step
  Affine3 world;  // from the index space of the (even) steps
  std::int64_t num_steps;
  double first_time, last_time;

  double scale() const noexcept;
  double step_distance() const noexcept;              // 1, or 1 / sqrt(2)
  double shift_of(std::int64_t step) const noexcept;  // 0 or scale / 2
  Vec4 size() const noexcept;  // of the box of all samples, which begins at 0
};

// docs/time.md, "Hyperslices". Throws Error(kInvalidArgument) as hyperslice() says.
class HyperplaneFrame {
 public:
  HyperplaneFrame(const SpaceTime& lattice, const Hyperplane& plane);

  // The axis that is not kept: 0 to 2, or 3 for time; and is the plane across it?
  int dropped() const noexcept { return dropped_; }
  bool is_across_axis() const noexcept { return is_across_axis_; }
  // Where it crosses that axis, T; of a plane across it.
  double place() const noexcept { return offset_ / normal_[dropped_]; }

  // Distance from the plane, T.
  double distance(const Vec4& position) const noexcept { return normal_.dot(position) - offset_; }
  Vec3 to_plane(const Vec4& position) const noexcept { return axes_.transpose() * position; }
  Vec4 from_plane(const Vec3& place) const noexcept { return offset_ * normal_ + axes_ * place; }
  // Of position by place in the plane: columns.
  const Eigen::Matrix<double, 4, 3>& axes() const noexcept { return axes_; }

  const Bounds3& bounds() const noexcept { return bounds_; }  // of the data's box, in the plane
  Affine3 world_from_plane() const noexcept { return world_; }

 private:
  Vec4 normal_;  // unit length
  double offset_ = 0;
  int dropped_ = 3;
  bool is_across_axis_ = false;
  Eigen::Matrix<double, 4, 3> axes_;
  Bounds3 bounds_;
  Affine3 world_;
};

}  // namespace ovoid::model
