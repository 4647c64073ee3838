// SPDX-License-Identifier: Apache-2.0
#include "hands.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ovoid::viewer {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

double half_height_at_focus(const Camera& camera) {
  const double distance = (camera.focal_point - camera.position).norm();
  return distance * std::tan(camera.view_angle / 2 / kDegrees);
}

}  // namespace

void orbit(Camera& camera, const Vec2& moved, double height) {
  const double degrees_per_pixel = 180 / height;
  camera.azimuth(-moved.x() * degrees_per_pixel);
  camera.elevation(moved.y() * degrees_per_pixel);
}

void pan(Camera& camera, const Vec2& moved, double height) {
  const Projection projection(camera, height, height);
  const double size = projection.pixel_size_at(projection.focal_depth());
  const Vec3 shift = (projection.up() * moved.y() - projection.right() * moved.x()) * size;
  camera.position += shift;
  camera.focal_point += shift;
}

void roll_with(Camera& camera, const Vec2& from, const Vec2& to, const Vec2& middle) {
  const Vec2 a = from - middle;
  const Vec2 b = to - middle;
  if (a.norm() < 1 || b.norm() < 1) return;  // there is no angle at the very middle
  const double angle = std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
  camera.roll(-angle * kDegrees);  // the world goes with the mouse, so the camera against it
}

void zoom_to(Camera& camera, double factor, const Vec2& cursor, const Vec2& size, double extent) {
  constexpr double kFarthest = 1e6;
  const double scale = camera.parallel_projection ? camera.parallel_scale
                                                  : (camera.focal_point - camera.position).norm();
  const double wanted = std::clamp(scale / factor, extent / kFarthest, extent * kFarthest);
  const double shrink = wanted / scale;
  const Projection projection(camera, size.x(), size.y());
  const Vec3 fixed = projection.world_at(cursor, projection.focal_depth());
  const Vec3 shift = (fixed - camera.focal_point) * (1 - shrink);
  if (camera.parallel_projection) {
    camera.parallel_scale = wanted;
    camera.position += shift;
  } else {
    camera.position = fixed + (camera.position - fixed) * shrink;
  }
  camera.focal_point += shift;
}

void toggle_projection(Camera& camera) {
  if (camera.parallel_projection) {
    const double distance = (camera.focal_point - camera.position).norm();
    const double wanted = distance * camera.parallel_scale / half_height_at_focus(camera);
    const Vec3 back = (camera.position - camera.focal_point).normalized();
    camera.position = camera.focal_point + back * wanted;
  } else {
    camera.parallel_scale = half_height_at_focus(camera);
  }
  camera.parallel_projection = !camera.parallel_projection;
}

}  // namespace ovoid::viewer
