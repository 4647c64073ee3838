// SPDX-License-Identifier: Apache-2.0
#include "model/time/hyperplane_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "ovoid/error.h"

namespace ovoid::model {
namespace {

constexpr double kSqrt2 = std::numbers::sqrt2;

// Of a plane that is meant to be across an axis, but for rounding.
constexpr double kAcross = 1e-9;

[[noreturn]] void refuse_plane(const std::string& what) {
  throw Error(ErrorCode::kInvalidArgument, "hyperslice: " + what);
}

}  // namespace

double SpaceTime::scale() const noexcept { return kind == SeriesKind::kStaggered ? kSqrt2 : 1.0; }

double SpaceTime::step_distance() const noexcept {
  return kind == SeriesKind::kStaggered ? 1 / kSqrt2 : 1.0;
}

double SpaceTime::shift_of(std::int64_t step) const noexcept {
  return kind == SeriesKind::kStaggered && step % 2 != 0 ? 0.5 * scale() : 0.0;
}

Vec4 SpaceTime::size() const noexcept {
  Vec4 size;
  for (int a = 0; a < 3; ++a)
    size[a] = scale() * static_cast<double>(dims[static_cast<std::size_t>(a)] - 1) +
              (num_steps > 1 ? shift_of(1) : 0.0);
  size[3] = step_distance() * static_cast<double>(num_steps - 1);
  return size;
}

HyperplaneFrame::HyperplaneFrame(const SpaceTime& lattice, const Hyperplane& plane) {
  const Vec3 space(plane.normal[0], plane.normal[1], plane.normal[2]);
  const double time = plane.normal[3];
  if (!space.allFinite() || !std::isfinite(time) || !std::isfinite(plane.offset))
    refuse_plane("the plane's numbers must be finite");
  if (space.isZero() && time == 0)
    refuse_plane("the plane has no direction: a, b, c and d are all 0");

  // The plane over positions in T.
  const double per_step =
      lattice.num_steps > 1 ? (lattice.last_time - lattice.first_time) / lattice.size()[3] : 1.0;
  Vec4 normal;
  normal.head<3>() = lattice.world.linear().transpose() * space / lattice.scale();
  normal[3] = time * per_step;
  const double offset =
      plane.offset - space.dot(lattice.world.translation()) - time * lattice.first_time;
  const Vec4 size = lattice.size();
  double least = 0;
  double greatest = 0;
  for (int a = 0; a < 4; ++a) {
    least += std::min(0.0, normal[a] * size[a]);
    greatest += std::max(0.0, normal[a] * size[a]);
  }
  const double rounding = 1e-9 * (greatest - least);
  if (!(offset >= least - rounding && offset <= greatest + rounding)) {
    const double shift = plane.offset - offset;
    refuse_plane(
        fmt::format("the plane misses the data, over which {:g} x + {:g} y + {:g} z + {:g} t "
                    "goes from {:g} to {:g}: e = {:g}",
                    plane.normal[0], plane.normal[1], plane.normal[2], time, least + shift,
                    greatest + shift, plane.offset));
  }
  const double length = normal.norm();
  if (!(length > 0) || !std::isfinite(length))
    refuse_plane("the plane's numbers are too small or large");
  normal_ = normal / length;
  offset_ = std::clamp(offset, least, greatest) / length;

  // Time, if it is as much of the normal as any other.
  dropped_ = 3;
  for (int a = 2; a >= 0; --a) {
    if (std::abs(normal_[a]) > std::abs(normal_[dropped_]) * (1 + 1e-12)) dropped_ = a;
  }
  const double rest = std::sqrt(std::max(0.0, 1 - normal_[dropped_] * normal_[dropped_]));
  is_across_axis_ = rest < kAcross;
  if (normal_[dropped_] < 0) {
    normal_ = -normal_;
    offset_ = -offset_;
  }
  if (is_across_axis_) normal_ = Vec4::Unit(dropped_);

  // The kept axes, by the rotation in the plane of the dropped one and the normal that takes one to
  // the other: v - (v . n) / (1 + c) (m + n) for v across m, where c = m . n.
  const Vec4 dropped = Vec4::Unit(dropped_);
  const Vec4 sum = (dropped + normal_) / (1 + normal_[dropped_]);
  Mat3 directions;  // in the world, of a T
  for (int a = 0; a < 3; ++a) {
    // Time is in the place of the axis that is not kept.
    const int axis = a == dropped_ ? 3 : a;
    axes_.col(a) = Vec4::Unit(axis) - normal_[axis] * sum;
    directions.col(a) = lattice.world.linear().col(a) / lattice.scale();
  }

  // What of the box lies in the plane: its corners are on the box's edges.
  for (int axis = 0; axis < 4; ++axis) {
    for (int which = 0; which < 8; ++which) {
      Vec4 from;
      for (int a = 0, bit = 0; a < 4; ++a)
        from[a] = a == axis ? 0.0 : (which >> bit++ & 1) * size[a];
      const double before = distance(from);
      const double reach = normal_[axis] * size[axis];
      const double slack = 1e-9 * size.norm();
      if (std::abs(reach) <= slack) {
        if (std::abs(before) > slack) continue;
        bounds_.extend(Vec3(to_plane(from)));
        from[axis] = size[axis];
      } else {
        const double share = -before / reach;
        if (share < -1e-9 || share > 1 + 1e-9) continue;
        from[axis] = std::clamp(share, 0.0, 1.0) * size[axis];
      }
      bounds_.extend(Vec3(to_plane(from)));
    }
  }
  if (bounds_.isEmpty()) refuse_plane("the plane touches the data in no more than a corner");

  world_.setIdentity();
  world_.linear() = directions;
  // Of all the slice, its middle is where it was.
  const Vec3 middle = 0.5 * (bounds_.min() + bounds_.max());
  const Vec4 was = from_plane(middle);
  Vec3 kept;
  for (int a = 0; a < 3; ++a) kept[a] = was[a == dropped_ ? 3 : a];
  world_.translation() = lattice.world.translation() + directions * (kept - middle);
}

}  // namespace ovoid::model
