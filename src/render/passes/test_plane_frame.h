// SPDX-License-Identifier: Apache-2.0
// What tests of value planes share: scenes, and where a ray meets a plane, worked out anew.
#pragma once

#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "ovoid/renderer.h"
#include "support/scenes.h"
#include "support/volumes.h"

namespace ovoid::value_plane_test {

using namespace test;

inline constexpr int kWidth = 72;
inline constexpr int kHeight = 60;

struct PlaneScene {
  Field field;
  Camera camera;
  Look look;
  ValuePlane plane;
  RenderOptions options = picture(kWidth, kHeight);
};

inline Frame draw(const PlaneScene& scene, int threads = 2, const RenderHooks& hooks = {}) {
  Renderer renderer(Backend::kCpu, threads);
  Scene with_plane(scene.field, scene.look);
  with_plane.plane = scene.plane;
  return renderer.render(with_plane, scene.camera, scene.options, hooks);
}

// The same without the plane, or with it as a clip plane that keeps one side.
inline Image draw_volume(const PlaneScene& scene, double side = 0) {
  RenderOptions options = scene.options;
  if (side != 0)
    options.clip_planes.push_back({side * scene.plane.normal, side * scene.plane.offset});
  return Renderer(Backend::kCpu, 2).render({scene.field, scene.look}, scene.camera, options).image;
}

inline Look without_opacity(Look look) {
  look.transfer_function.opacities = {{0, 0}};
  return look;
}

// What the plane alone gives.
inline Image draw_plane(PlaneScene scene) {
  scene.look = without_opacity(scene.look);
  scene.look.mode = Mode::kComposite;
  return draw(scene).image;
}

struct Place {
  Vec3 at;
  double depth;
};

// Where a pixel's ray meets the plane, worked out from the camera's own words.
inline std::optional<Place> place_on_plane(const PlaneScene& scene, int x, int y) {
  const Camera& camera = scene.camera;
  const Vec3 axis = (camera.focal_point - camera.position).normalized();
  const Vec3 right = axis.cross(camera.view_up).normalized();
  const Vec3 up = right.cross(axis);
  const double aspect = static_cast<double>(scene.options.width) / scene.options.height;
  const Vec3 aside = (2 * (x + 0.5) / scene.options.width - 1) * aspect * right +
                     (1 - 2 * (y + 0.5) / scene.options.height) * up;
  Vec3 origin = camera.position;
  Vec3 direction = axis;
  if (camera.parallel_projection) {
    origin += camera.parallel_scale * aside;
  } else {
    direction += std::tan(camera.view_angle * std::numbers::pi / 360) * aside;
  }
  const double depth =
      (scene.plane.offset - scene.plane.normal.dot(origin)) / scene.plane.normal.dot(direction);
  if (!std::isfinite(depth) || (!camera.parallel_projection && depth <= 0)) return std::nullopt;
  return Place{origin + depth * direction, depth};
}

// Steps along x, y and z from one sample to the next.
inline const Vec3 kSlope(0.03, 0.02, -0.025);
inline const Index3 kDims{14, 12, 16};

inline LatticeField linear_field(const FieldSetup& setup = {}) {
  return make_field(
      kDims,
      [](std::int64_t i, std::int64_t j, std::int64_t k) {
        return 0.5 + kSlope.dot(Vec3(static_cast<double>(i), static_cast<double>(j),
                                     static_cast<double>(k)));
      },
      setup);
}

inline std::vector<Camera> cameras() {
  const Vec3 middle(6.5, 5.5, 7.5);
  std::vector<Camera> all;
  for (const Vec3& towards : {Vec3(1, 0.3, 0.2), Vec3(-1, -0.4, 0.3), Vec3(0.1, 0.3, -1)}) {
    all.push_back(parallel_camera(middle, towards, 11));
    all.push_back(perspective_camera(middle, towards, 11, 40));
  }
  return all;
}

inline ValuePlane plane_through(const Vec3& normal, const Vec3& point) {
  return {normal, normal.dot(point)};
}

inline std::vector<ValuePlane> planes() {
  return {plane_through({1, 0, 0}, {6.2, 0, 0}), plane_through({0, 0, -3}, {0, 0, 7.7}),
          plane_through({1, 2, -0.5}, {6.5, 5.5, 7.5})};
}

inline PlaneScene linear_scene(double opacity = 0) {
  PlaneScene scene{linear_field(), cameras()[1], gray_look(-0.2, 1.4, opacity), planes()[2]};
  return scene;
}

}  // namespace ovoid::value_plane_test
