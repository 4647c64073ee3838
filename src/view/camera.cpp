// SPDX-License-Identifier: Apache-2.0
#include "ovoid/camera.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string_view>
#include <utility>

#include "ovoid/error.h"

namespace ovoid {
namespace {

// Below this sine between view axis and view_up the right axis would lose more than ten of double's
// sixteen digits.
constexpr double kMinUpSine = 1e-6;

// The radius that vtkRenderer::ResetCamera gives a box without extent (half of a unit diagonal).
constexpr double kPointRadius = 0.5;

// How far rounding may move a camera, of its distance; rays are off as much then.
constexpr double kMostRounding = 0.05;

double radians(double degrees) { return degrees * (std::numbers::pi / 180.0); }

std::string text(const Vec3& v) { return fmt::format("({}, {}, {})", v.x(), v.y(), v.z()); }

[[noreturn]] void refuse(const std::string& message) {
  throw Error(ErrorCode::kInvalidArgument, message);
}

void require_finite(const char* name, const Vec3& v) {
  if (!v.allFinite()) refuse(fmt::format("camera {} = {}: must be finite", name, text(v)));
}

Vec3 turned(const Vec3& v, double degrees, const Vec3& axis) {
  return Eigen::AngleAxisd(radians(degrees), axis.normalized()) * v;
}

// A view by name: the camera stands at `from` (as seen from the focal point), `up` points up in the
// picture.
struct NamedView {
  std::string_view name;
  Vec3 from;
  Vec3 up;
};

std::array<NamedView, 6> axis_views() {
  const Vec3 x = Vec3::UnitX();
  const Vec3 y = Vec3::UnitY();
  const Vec3 z = Vec3::UnitZ();
  return {NamedView{"+z", z, y},  NamedView{"-z", -z, y}, NamedView{"+x", x, z},
          NamedView{"-x", -x, z}, NamedView{"+y", y, z},  NamedView{"-y", -y, z}};
}

// Directions as a person means them: out of the face towards the viewer, to the viewer's right, up.
struct Facing {
  Vec3 front, right, up;
};

// LPS: +x left, +y posterior. RAS: +x right, +y anterior. Both: +z superior. A patient's left is to
// the right of who faces them. Data of no patient stand on the plane z = 0, and face -y.
Facing facing(Space space) {
  const double sign = space == Space::kRas ? -1.0 : 1.0;
  return {-sign * Vec3::UnitY(), sign * Vec3::UnitX(), Vec3::UnitZ()};
}

// Turned by `azimuth` to the right and raised by 20 degrees.
Vec3 slanted(const Facing& facing, double azimuth) {
  const double turn = radians(azimuth);
  const double rise = radians(20);
  return std::cos(rise) * (std::cos(turn) * facing.front + std::sin(turn) * facing.right) +
         std::sin(rise) * facing.up;
}

std::array<NamedView, 8> faced_views(Space space) {
  const Facing f = facing(space);
  const bool is_patient = space != Space::kNone;
  // A patient's own left and right, and otherwise those of the picture.
  const Vec3 left = is_patient ? f.right : Vec3(-f.right);
  return {NamedView{"front", f.front, f.up},
          NamedView{"back", -f.front, f.up},
          NamedView{"left", left, f.up},
          NamedView{"right", -left, f.up},
          NamedView{"top", f.up, is_patient ? f.front : Vec3(-f.front)},
          NamedView{"bottom", -f.up, is_patient ? f.front : Vec3(-f.front)},
          NamedView{"three-quarter", slanted(f, 30), f.up},
          NamedView{"three-quarter-side", slanted(f, 60), f.up}};
}

// Their names in anatomy, where there is a patient.
constexpr std::array<std::pair<std::string_view, std::string_view>, 4> kAnatomy = {
    std::pair{"anterior", "front"}, std::pair{"posterior", "back"}, std::pair{"superior", "top"},
    std::pair{"inferior", "bottom"}};

NamedView named_view(const std::string& name, Space space) {
  if (name.empty()) return space == Space::kNone ? axis_views()[0] : faced_views(space)[0];
  for (const NamedView& view : axis_views()) {
    if (view.name == name) return view;
  }
  std::string_view wanted = name;
  for (const auto& [anatomical, plain] : kAnatomy) {
    if (name != anatomical) continue;
    if (space == Space::kNone) {
      refuse(fmt::format(
          "view = {}: the data has no patient space (LPS or RAS); use {}, or +x -x +y -y +z -z",
          name, plain));
    }
    wanted = plain;
  }
  for (const NamedView& view : faced_views(space)) {
    if (view.name == wanted) return view;
  }
  refuse(fmt::format("view = {}: must be one of {}", name, fmt::join(view_names(), " ")));
}

}  // namespace

void Camera::validate() const {
  require_finite("position", position);
  require_finite("focal_point", focal_point);
  require_finite("view_up", view_up);
  const Vec3 axis = focal_point - position;
  const double distance = axis.norm();
  if (!(distance > 0.0) || !std::isfinite(distance)) {
    refuse(fmt::format("camera position = {}: must differ from focal_point by a finite distance",
                       text(position)));
  }
  const double sine = (axis / distance).cross(view_up.normalized()).norm();
  if (!(sine > kMinUpSine)) {
    refuse(fmt::format("camera view_up = {}: must not be zero or parallel to the view axis",
                       text(view_up)));
  }
  if (!(parallel_scale > 0.0) || !std::isfinite(parallel_scale)) {
    refuse(fmt::format("camera parallel_scale = {}: must be finite and > 0", parallel_scale));
  }
  if (!(view_angle > 0.0 && view_angle < 180.0)) {
    refuse(fmt::format("camera view_angle = {}: must be between 0 and 180 degrees", view_angle));
  }
}

void Camera::azimuth(double degrees) {
  position = focal_point + turned(position - focal_point, degrees, view_up);
}

void Camera::elevation(double degrees) {
  const Vec3 right = (focal_point - position).cross(view_up).normalized();
  position = focal_point + turned(position - focal_point, degrees, -right);
  // From the kept right axis, so that a motion over the pole neither degenerates nor flips the
  // picture.
  view_up = right.cross(focal_point - position).normalized();
}

void Camera::roll(double degrees) { view_up = turned(view_up, degrees, focal_point - position); }

void Camera::zoom(double factor) {
  if (!(factor > 0.0) || !std::isfinite(factor)) {
    refuse(fmt::format("zoom factor = {}: must be finite and > 0", factor));
  }
  (parallel_projection ? parallel_scale : view_angle) /= factor;
}

std::vector<std::string> view_names() {
  std::vector<std::string> names;
  for (const NamedView& view : axis_views()) names.emplace_back(view.name);
  for (const NamedView& view : faced_views(Space::kNone)) names.emplace_back(view.name);
  for (const auto& [anatomical, plain] : kAnatomy) names.emplace_back(anatomical);
  return names;
}

Camera default_camera(const Bounds3& world_bounds, Space space, const std::string& view,
                      double aspect) {
  if (world_bounds.isEmpty() || !world_bounds.min().allFinite() ||
      !world_bounds.max().allFinite()) {
    refuse(fmt::format("bounds = {} to {}: must be a finite box that is not empty",
                       text(world_bounds.min()), text(world_bounds.max())));
  }
  if (!(aspect > 0.0) || !std::isfinite(aspect)) {
    refuse(fmt::format("aspect = {}: must be finite and > 0", aspect));
  }
  const NamedView named = named_view(view, space);
  const double half_diagonal = 0.5 * world_bounds.diagonal().norm();
  const double radius = half_diagonal > 0.0 ? half_diagonal : kPointRadius;

  // As vtkRenderer::ResetCamera: the bounding sphere touches the sides of the view cone. In an
  // upright picture the narrower, horizontal angle decides.
  Camera camera;
  const double narrow = std::min(aspect, 1.0);
  const double half_angle = std::atan(std::tan(radians(camera.view_angle) / 2.0) * narrow);
  const double distance = radius / std::sin(half_angle);
  camera.focal_point = world_bounds.center();
  camera.position = camera.focal_point + distance * named.from;
  const double rounding =
      camera.focal_point.cwiseAbs().maxCoeff() * std::numeric_limits<double>::epsilon() / 2;
  if (!std::isfinite(distance) || !(rounding <= kMostRounding * distance)) {
    refuse(fmt::format(
        "bounds = {} to {}: lie so far from the origin, or apart, that numbers of 64 bits do not "
        "tell places around them apart; move the data to the origin, or give lengths in a larger "
        "unit",
        text(world_bounds.min()), text(world_bounds.max())));
  }
  camera.view_up = named.up;
  camera.parallel_scale = radius / narrow;
  return camera;
}

}  // namespace ovoid
