// SPDX-License-Identifier: Apache-2.0
#include "render/passes/plane_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "data/kernels/kernel_weight.h"
#include "view/plan/kernel_plan.h"
#include "view/plan/pixel_rays.h"

namespace ovoid {
namespace {

double distance_of_sheets(const Field& field, const RenderOptions& options) {
  return options.sampling_distance > 0 ? options.sampling_distance
                                       : field.default_sampling_distance();
}

// Where the field of a lattice can be defined, index units beyond the faces of its outermost cells:
// sums as far as kernels reach, normalized ones a little (docs/numerics.md, "The field").
double reach_of(const LatticeField& field, double widening) {
  const LatticeKernel kernel = field.index_kernel();
  const double half_cell = 0.5 / field.geometry().num_sublattices();
  return field.reconstruction() == Reconstruction::kSum
             ? kernel.support_radius() * widening - half_cell
             : data::face_reach(kernel) + 0.5 - half_cell + 1e-3;
}

// A convex polygon's part in a half space.
std::vector<Vec3> cut(const std::vector<Vec3>& polygon, const ClipPlane& plane) {
  std::vector<Vec3> part;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3& from = polygon[i];
    const Vec3& to = polygon[(i + 1) % polygon.size()];
    const double a = plane.normal.dot(from) - plane.offset;
    const double b = plane.normal.dot(to) - plane.offset;
    if (a >= 0) part.push_back(from);
    if ((a >= 0) != (b >= 0)) part.emplace_back(from + a / (a - b) * (to - from));
  }
  return part;
}

ClipPlane through(const Vec3& point, const Vec3& normal) { return {normal, normal.dot(point)}; }

}  // namespace

PlaneView::PlaneView(const Field& field, const Camera& camera, const ValuePlane& plane,
                     const RenderOptions& options)
    : width_(options.width),
      height_(options.height),
      clip_planes_(options.clip_planes),
      lattice_(camera, options.width, options.height, distance_of_sheets(field, options),
               LatticeGeometry{.dims = {1, 1, 1}}),
      eye_(camera.position),
      right_(lattice_.view_axis().cross(camera.view_up).normalized()),
      up_(right_.cross(lattice_.view_axis())),
      half_height_(camera.parallel_projection
                       ? camera.parallel_scale
                       : std::tan(camera.view_angle * std::numbers::pi / 360.0)),
      origins_(view::PixelRays(lattice_).origins()),
      directions_(lattice_.ray_direction()) {
  set_box(field);
  decide_sides(plane);
}

void PlaneView::set_box(const Field& field) {
  // Kernels may be as wide as a pixel, at the far end of the field.
  double pitch = 0;
  const Bounds3 bounds = field.world_bounds();
  for (int corner = 0; corner < 8; ++corner)
    pitch = std::max(pitch, pitch_at(bounds.corner(static_cast<Bounds3::CornerType>(corner))));
  if (const LatticeField* lattice = field.lattice()) {
    box_ = box_of(lattice->geometry());
    const double widening = std::max(1.0, pitch / lattice->geometry().spacing().minCoeff());
    const double reach = reach_of(*lattice, widening);
    faces_ = box_.bounds;
    box_.bounds.min().array() -= reach;
    box_.bounds.max().array() += reach;
    if (lattice->reconstruction() == Reconstruction::kSum) faces_ = box_.bounds;
  } else {
    const KernelSource& source = field.kernels()->source();
    for (std::int64_t b = 0; b < source.num_bricks(); ++b)
      box_.bounds.extend(source.brick(b).support);
    const double reach = 0.5 * view::kLeastPixels * source.cutoff() * pitch;
    box_.bounds.min().array() -= reach;
    box_.bounds.max().array() += reach;
    faces_ = box_.bounds;
  }
  box_from_world_ = box_.world_from_box.inverse();
  box_diagonal_ = box_.world_bounds().diagonal().norm();
}

void PlaneView::decide_sides(const ValuePlane& plane) {
  // What is nearer to being seen edge-on is narrower than a thirtieth of a pixel in any picture.
  constexpr double kEdgeOn = 1e-6;
  const double length = plane.normal.norm();
  normal_ = plane.normal / length;
  offset_ = plane.offset / length;
  const Vec3& axis = lattice_.view_axis();
  if (lattice_.is_parallel()) {
    const double along = normal_.dot(axis);
    is_met_ = std::abs(along) > kEdgeOn;
    if (along < 0) {
      normal_ = -normal_;
      offset_ = -offset_;
    }
  } else {
    // The normal points away from the eye's side.
    const double distance = offset_ - normal_.dot(eye_);
    if (distance < 0) {
      normal_ = -normal_;
      offset_ = -offset_;
    }
    const double farthest = (box_.world_bounds().center() - eye_).norm() + box_diagonal_;
    double steepest = 0;  // rays of the picture's corners come nearest to the plane
    for (const double x : {-0.5, width_ - 0.5}) {
      for (const double y : {-0.5, height_ - 0.5})
        steepest = std::max(steepest, normal_.dot(directions_.at(x, y)));
    }
    is_met_ = std::abs(distance) > kEdgeOn * farthest && steepest > 0;
  }
  // In the plane's own words, so that it cuts what the caller's own clip plane would.
  const ClipPlane own{plane.normal, plane.offset};
  const ClipPlane other{-plane.normal, -plane.offset};
  const bool is_along = normal_.dot(plane.normal) > 0;
  behind_ = is_along ? own : other;
  front_ = is_along ? other : own;
}

PlaneRay PlaneView::ray(int x, int y) const { return {origins_.at(x, y), directions_.at(x, y)}; }

std::optional<PlaneHit> PlaneView::hit(int x, int y) const {
  const PlaneRay from = ray(x, y);
  const double along = normal_.dot(from.direction);
  if (!(along > 0)) return std::nullopt;
  PlaneHit hit;
  hit.depth = (offset_ - normal_.dot(from.origin)) / along;
  if (!(hit.depth > lattice_.near_depth()) || !std::isfinite(hit.depth)) return std::nullopt;
  hit.at = from.origin + hit.depth * from.direction;
  // The neighbour's ray at this depth, moved along this one back onto the plane.
  const auto moved = [&](const Vec3& origin, const Vec3& direction) -> Vec3 {
    const Vec3 aside = origin + hit.depth * direction;
    return aside - normal_.dot(aside) / along * from.direction;
  };
  hit.per_x = moved(origins_.per_x, directions_.per_x);
  hit.per_y = moved(origins_.per_y, directions_.per_y);
  return hit;
}

bool PlaneView::is_kept(const Vec3& at) const {
  return std::all_of(clip_planes_.begin(), clip_planes_.end(),
                     [&](const ClipPlane& plane) { return plane.normal.dot(at) >= plane.offset; });
}

bool PlaneView::is_in_box(const Vec3& at) const {
  return box_.bounds.contains(box_from_world_ * at);
}

bool PlaneView::is_within_faces(const Vec3& at) const {
  return faces_.contains(box_from_world_ * at);
}

double PlaneView::pixels_within_faces(const PlaneHit& hit) const {
  const Vec3 at = box_from_world_ * hit.at;
  const Vec3 per_x = box_from_world_.linear() * hit.per_x;
  const Vec3 per_y = box_from_world_.linear() * hit.per_y;
  double least = std::numeric_limits<double>::infinity();
  for (int a = 0; a < 3; ++a) {
    const double within = std::min(at[a] - faces_.min()[a], faces_.max()[a] - at[a]);
    // Along faces that the plane never meets nothing ends.
    const double per_pixel = std::hypot(per_x[a], per_y[a]);
    if (within < 0 || per_pixel > 0) least = std::min(least, within / per_pixel);
  }
  return least;
}

bool PlaneView::meets_box_beyond(const PlaneRay& ray, double depth) const {
  const Vec3 from = box_from_world_ * ray.origin;
  const Vec3 along = box_from_world_.linear() * ray.direction;
  // A sample stands for half a sheet before and behind it.
  double begin = std::max(depth - 0.5 * lattice_.sampling_distance(), lattice_.near_depth());
  double end = std::numeric_limits<double>::infinity();
  for (int a = 0; a < 3; ++a) {
    if (along[a] == 0) {
      if (from[a] < box_.bounds.min()[a] || from[a] > box_.bounds.max()[a]) return false;
      continue;
    }
    const double t0 = (box_.bounds.min()[a] - from[a]) / along[a];
    const double t1 = (box_.bounds.max()[a] - from[a]) / along[a];
    begin = std::max(begin, std::min(t0, t1));
    end = std::min(end, std::max(t0, t1));
  }
  return begin < end;
}

double PlaneView::pitch_at(const Vec3& at) const {
  const double scale = lattice_.is_parallel()
                           ? 1.0
                           : std::max(lattice_.view_axis().dot(at - eye_), lattice_.near_depth());
  return 2 * half_height_ * scale / height_;
}

// The half spaces between which the picture lies, a pixel wider on all sides.
std::vector<ClipPlane> PlaneView::sides_of_view() const {
  const Vec3& axis = lattice_.view_axis();
  const double pixel = 2 * half_height_ / height_;
  const double half_x = (0.5 * width_ + 1) * pixel;
  const double half_y = (0.5 * height_ + 1) * pixel;
  std::vector<ClipPlane> sides;
  for (const auto& [side, half] : {std::pair{right_, half_x}, std::pair{up_, half_y}}) {
    for (const double sign : {-1.0, 1.0}) {
      const Vec3 inwards = sign * side;
      if (lattice_.is_parallel()) {
        sides.push_back(through(eye_ - half * inwards, inwards));
      } else {
        sides.push_back(through(eye_, half * axis + inwards));
      }
    }
  }
  if (!lattice_.is_parallel()) sides.push_back(through(eye_ + lattice_.near_depth() * axis, axis));
  return sides;
}

std::vector<Vec3> PlaneView::footprint() const {
  const Vec3 middle = box_.world_bounds().center();
  const Vec3 center = middle - (normal_.dot(middle) - offset_) * normal_;
  const Vec3 u = normal_.unitOrthogonal() * box_diagonal_;
  const Vec3 v = normal_.cross(u);
  std::vector<Vec3> polygon{center - u - v, center + u - v, center + u + v, center - u + v};
  const Mat3 axes = box_from_world_.linear();
  for (int a = 0; a < 3; ++a) {
    const Vec3 face = axes.row(a).transpose();
    const double shift = box_from_world_.translation()[a];
    polygon = cut(polygon, {face, box_.bounds.min()[a] - shift});
    polygon = cut(polygon, {-face, shift - box_.bounds.max()[a]});
  }
  for (const ClipPlane& plane : clip_planes_) polygon = cut(polygon, plane);
  for (const ClipPlane& plane : sides_of_view()) polygon = cut(polygon, plane);
  return polygon;
}

}  // namespace ovoid
