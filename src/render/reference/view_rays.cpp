// SPDX-License-Identifier: Apache-2.0
#include "render/reference/view_rays.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "ovoid/error.h"

namespace ovoid::reference {
namespace {

// More sheets along one ray than anybody waits for; keeps sheet numbers exact in a double and an
// int64.
constexpr double kMaxSheets = 1e9;

// Cosine between normal and view axis from which a plane's cut is seen in parallel projection.
constexpr double kEdgeOn = 1e-6;

// An interval of z along a ray; empty if lo > hi.
struct Interval {
  double lo = -std::numeric_limits<double>::infinity();
  double hi = std::numeric_limits<double>::infinity();

  // Keeps the z with slope * z >= bound.
  void keep(double slope, double bound) {
    if (slope > 0) {
      lo = std::max(lo, bound / slope);
    } else if (slope < 0) {
      hi = std::min(hi, bound / slope);
    } else if (bound > 0) {
      hi = -std::numeric_limits<double>::infinity();
    }
  }
};

}  // namespace

ViewRays::ViewRays(const Camera& camera, const RenderOptions& options, double default_distance)
    : clip_planes_(options.clip_planes),
      position_(camera.position),
      forward_((camera.focal_point - camera.position).normalized()),
      right_(forward_.cross(camera.view_up).normalized()),
      up_(right_.cross(forward_)),
      is_perspective_(!camera.parallel_projection),
      half_height_(is_perspective_ ? std::tan(0.5 * camera.view_angle * std::numbers::pi / 180)
                                   : camera.parallel_scale),
      width_(options.width),
      height_(options.height),
      ds_(options.sampling_distance > 0 ? options.sampling_distance : default_distance),
      z_focal_((camera.focal_point - camera.position).norm()) {
  for (const ClipPlane& plane : clip_planes_) {
    const double length = plane.normal.norm();
    const ClipPlane unit{plane.normal / length, plane.offset / length};
    const bool is_seen = is_perspective_ ? unit.normal.dot(position_) < unit.offset
                                         : unit.normal.dot(forward_) > kEdgeOn;
    if (is_seen) cut_faces_.push_back(unit);
  }
}

ViewRays::ViewRays(const LatticeField& field, const Camera& camera, const RenderOptions& options,
                   const view::BasePlane* base)
    : ViewRays(camera, options, field.default_sampling_distance()) {
  base_ = base;
  index_from_world_ = field.geometry().world_from_index.inverse();
  spacing_ = field.geometry().spacing();
  for (int a = 0; a < 3; ++a) {
    const auto cells = static_cast<double>(field.geometry().cells()[a]);
    widest_[a] = std::max(1.0, cells / (4 * field.index_kernel().sigma));
  }
}

ViewRays::ViewRays(const KernelField& field, const Camera& camera, const RenderOptions& options)
    : ViewRays(camera, options, field.default_sampling_distance()) {}

Ray ViewRays::ray(double x, double y) const {
  if (base_ != nullptr) {
    const Vec3 across = base_->corner + x * base_->per_x + y * base_->per_y;
    return is_perspective_ ? Ray{position_, forward_ + across} : Ray{position_ + across, forward_};
  }
  const double aspect = static_cast<double>(width_) / height_;
  const double across = (2 * (x + 0.5) / width_ - 1) * aspect;  // X
  const double upwards = 1 - 2 * (y + 0.5) / height_;           // Y
  const Vec3 offset = half_height_ * (across * right_ + upwards * up_);
  if (is_perspective_) return {position_, forward_ + offset};
  return {position_ + offset, forward_};
}

Vec3 ViewRays::widening(std::int64_t sheet) const {
  if (base_ != nullptr) return Vec3::Ones();
  const double pitch = pitch_at(z_of(sheet));
  return (pitch * spacing_.cwiseInverse()).cwiseMin(widest_).cwiseMax(Vec3::Ones());
}

Vec3 ViewRays::greatest_widening() const {
  if (base_ != nullptr) return Vec3::Ones();
  return is_perspective_ ? widest_ : widening(0);
}

ZRange ViewRays::kept(const Ray& ray, ZRange range) const {
  Interval kept{range.lo, range.hi};
  if (is_perspective_) kept.lo = std::max(kept.lo, z_near());
  for (const ClipPlane& plane : clip_planes_) {
    kept.keep(plane.normal.dot(ray.direction), plane.offset - plane.normal.dot(ray.origin));
  }
  return {kept.lo, kept.hi};
}

double ViewRays::path(const Ray& ray, std::int64_t sheet) const {
  const ZRange part = kept(ray, {z_of(sheet) - 0.5 * ds_, z_of(sheet) + 0.5 * ds_});
  return std::max(part.hi - part.lo, 0.0) * ray.direction.norm();
}

ZRange ViewRays::inside(const Ray& ray, const Bounds3& box) const {
  const Vec3 origin = index_from_world_ * ray.origin;
  const Vec3 direction = index_from_world_.linear() * ray.direction;
  Interval inside;
  for (int a = 0; a < 3; ++a) {
    inside.keep(direction[a], box.min()[a] - origin[a]);
    inside.keep(-direction[a], origin[a] - box.max()[a]);
  }
  return {inside.lo, inside.hi};
}

bool ViewRays::is_kept(const Vec3& position) const {
  return std::all_of(clip_planes_.begin(), clip_planes_.end(), [&](const ClipPlane& plane) {
    return plane.normal.dot(position) >= plane.offset;
  });
}

std::optional<double> ViewRays::clearance(const Vec3& position) const {
  std::optional<double> least;
  for (const ClipPlane& plane : cut_faces_) {
    const double distance = plane.normal.dot(position) - plane.offset;
    if (!least || distance < *least) least = distance;
  }
  return least;
}

SheetRange ViewRays::sheets_within(const Ray& ray, const Bounds3& box) const {
  ZRange inside = this->inside(ray, box);
  if (is_perspective_) inside.lo = std::max(inside.lo, z_near());
  if (!(inside.lo <= inside.hi)) return {};
  // Half a slab, and one sheet more for rounding, on either side.
  const double first = std::floor((inside.lo - z_focal_) / ds_ - 2);
  const double last = std::ceil((inside.hi - z_focal_) / ds_ + 1);
  if (!(last - first <= kMaxSheets && std::abs(first) < 1e15 && std::abs(last) < 1e15)) {
    throw Error(
        ErrorCode::kInvalidArgument,
        "sampling_distance = " + std::to_string(ds_) +
            ": too small for this volume and camera; expected at most 1e9 sheets along a ray");
  }
  return {static_cast<std::int64_t>(first), static_cast<std::int64_t>(last)};
}

double ViewRays::pixel_step(std::int64_t sheet) const {
  const double pixel = pitch_at(z_of(sheet));
  const Mat3 linear = index_from_world_.linear();
  return std::max((linear * (pixel * right_)).norm(), (linear * (pixel * up_)).norm());
}

Mat3 ViewRays::position_derivatives(const Ray& ray, std::int64_t sheet) const {
  const double pixel = pitch_at(z_of(sheet));
  Mat3 derivatives;
  derivatives << pixel * right_, -pixel * up_, ds_ * ray.direction;
  return derivatives;
}

}  // namespace ovoid::reference
