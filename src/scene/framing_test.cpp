// SPDX-License-Identifier: Apache-2.0
#include "ovoid/framing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "ovoid/error.h"
#include "support/volumes.h"

namespace ovoid {
namespace framing_test {

// A ball of radius 6 off the middle of a lattice of 48^3 samples.
const Vec3 kBallCenter(14, 30, 24);
constexpr double kBallRadius = 6;

LatticeField ball_field() {
  return test::make_field({48, 48, 48}, [](std::int64_t i, std::int64_t j, std::int64_t k) {
    const Vec3 place(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
    return (place - kBallCenter).norm() < kBallRadius ? 1.0 : 0.0;
  });
}

Look ball_look() {
  Look look;
  look.transfer_function.colors = {{0, {1, 1, 1}}, {1, {1, 1, 1}}};
  look.transfer_function.opacities = {{0.4, 0.0}, {0.6, 0.9}};
  return look;
}

// Tangents of the angles from the view axis, right and up; of parallel projection, lengths.
Eigen::Vector2d seen_at(const Camera& camera, const Vec3& place) {
  const Vec3 away = (camera.focal_point - camera.position).normalized();
  const Vec3 right = away.cross(camera.view_up).normalized();
  const Vec3 from_eye = place - camera.position;
  const double scale = camera.parallel_projection ? 1 : from_eye.dot(away);
  return {from_eye.dot(right) / scale, from_eye.dot(right.cross(away)) / scale};
}

double half_height(const Camera& camera) {
  return camera.parallel_projection ? camera.parallel_scale
                                    : std::tan(camera.view_angle * std::numbers::pi / 360);
}

TEST(Framing, WhatShowsFillsThePictureFromEverywhere) {
  const LatticeField field = ball_field();
  const Bounds3 bounds = field.world_bounds();
  for (const bool is_parallel : {false, true}) {
    for (const char* const view : {"+x", "-y", "+z", "three-quarter", "three-quarter-side"}) {
      Camera start = default_camera(bounds, Space::kNone, view);
      start.parallel_projection = is_parallel;
      for (const double aspect : {0.5, 1.0, 2.0}) {
        const Camera camera = framed(start, {field, ball_look()}, {.aspect = aspect});
        // Not turned.
        const Vec3 before = (start.focal_point - start.position).normalized();
        EXPECT_LT((before - (camera.focal_point - camera.position).normalized()).norm(), 1e-12);
        const Eigen::Vector2d middle = seen_at(camera, kBallCenter);
        const double wide = half_height(camera) * std::min(aspect, 1.0);
        EXPECT_LT(middle.norm(), 0.06 * wide) << view;
        const double distance = (kBallCenter - camera.position).norm();
        const double ball = is_parallel ? kBallRadius : kBallRadius / distance;
        EXPECT_GT(ball / wide, 0.78) << view << ' ' << aspect;
        EXPECT_LT(ball / wide, 0.97) << view << ' ' << aspect;
      }
    }
  }
}

// A surface around what is less is framed as that around what is more.
TEST(Framing, IsosurfacesOfDistancesFillThePicture) {
  Look look = ball_look();
  look.mode = Mode::kIsosurface;
  look.isovalue = 0.5;
  const LatticeField more = ball_field();
  const LatticeField less =
      test::make_field({48, 48, 48}, [](std::int64_t i, std::int64_t j, std::int64_t k) {
        const Vec3 place(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
        return (place - kBallCenter).norm() < kBallRadius ? 0.0 : 1.0;
      });
  const Camera start = default_camera(more.world_bounds(), Space::kNone, "three-quarter");
  const Camera camera = framed(start, {more, look});
  EXPECT_LT(seen_at(camera, kBallCenter).norm(), 0.06 * half_height(camera));
  EXPECT_EQ(framed(start, {less, look}).position, camera.position);
}

// Turned around its focal point, the ball stays within the picture.
TEST(Framing, ForTurningAllStaysInSight) {
  const LatticeField field =
      test::make_field({64, 16, 16}, [](std::int64_t, std::int64_t, std::int64_t) { return 1.0; });
  const Bounds3 bounds = field.world_bounds();
  const Camera start = default_camera(bounds, Space::kNone, "+x");
  Camera camera = framed(start, {field, ball_look()}, {.aspect = 1.5, .is_for_turning = true});
  for (int turn = 0; turn < 12; ++turn) {
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector2d at =
          seen_at(camera, bounds.corner(static_cast<Bounds3::CornerType>(corner)));
      EXPECT_LT(at.cwiseAbs().maxCoeff(), half_height(camera));
    }
    camera.azimuth(30);
  }
}

TEST(Framing, ClipPlanesLeaveTheirHalf) {
  const LatticeField field =
      test::make_field({64, 16, 16}, [](std::int64_t, std::int64_t, std::int64_t) { return 1.0; });
  const Camera start = default_camera(field.world_bounds(), Space::kNone, "+z");
  const Camera whole = framed(start, {field, ball_look()});
  Framing framing;
  framing.clip_planes = {{Vec3(1, 0, 0), 48}};
  const Camera cut = framed(start, {field, ball_look()}, framing);
  EXPECT_GT(cut.focal_point.x(), 50);
  EXPECT_LT((cut.position - cut.focal_point).norm(),
            0.6 * (whole.position - whole.focal_point).norm());
}

// What is left of a triangle is framed, though one of its corners alone is.
TEST(Framing, CutSurfacesFillThePictureToo) {
  Surface surface;
  surface.places = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  for (const Vec3& place : surface.places) surface.bounds.extend(place);
  surface.triangles.push_back({.corners = {0, 1, 2}});
  Camera start = default_camera(surface.bounds, Space::kNone, "+z", 1);
  start.parallel_projection = true;
  Scene scene(ball_field(), ball_look());
  scene.volumes.front().boundary = std::make_shared<Surface>(surface);
  scene.volumes.front().walls = {1, false};
  const Camera camera = framed(start, scene, {.clip_planes = {{Vec3(1, 0, 0), 1}}});
  // x from 1 to 4, y from 0 to 3.
  EXPECT_NEAR(camera.focal_point.x(), 2.5, 1e-3);
  EXPECT_NEAR(camera.focal_point.y(), 1.5, 1e-3);
  EXPECT_NEAR(half_height(camera), 1.5 / 0.9, 0.02);
}

// Single samples far away, and what is nearly invisible, do not count.
TEST(Framing, SpecksAndHazeArePassedOver) {
  const Vec3 center(46, 50, 48);
  const auto field_with = [&](double speck, double haze) {
    return test::make_field({96, 96, 96}, [=](std::int64_t i, std::int64_t j, std::int64_t k) {
      const Vec3 place(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
      if (i == 94 && j == 2 && k == 2) return speck;
      return (place - center).norm() < 44 ? 1.0 : haze;
    });
  };
  Look look = ball_look();
  look.transfer_function.opacities = {{0.1, 0.0}, {0.15, 0.0001}, {0.4, 0.0001}, {0.6, 0.9}};
  const LatticeField plain = field_with(0, 0);
  const Camera start = default_camera(plain.world_bounds(), Space::kNone, "+z");
  const Camera without = framed(start, {plain, look});
  const Camera with = framed(start, {field_with(1, 0.2), look});
  EXPECT_LT((with.focal_point - without.focal_point).norm(), 1);
  EXPECT_NEAR((with.position - with.focal_point).norm(),
              (without.position - without.focal_point).norm(), 5);
}

// The places seen of a field and its trail reach from the one to the other, however faint the trail
// is beside the field; what no picture shows of it does not count.
TEST(Framing, TrailsFillThePictureByThemselves) {
  const auto ball_at = [](const Vec3& center) {
    return test::make_field({96, 24, 24}, [=](std::int64_t i, std::int64_t j, std::int64_t k) {
      const Vec3 place(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
      return (place - center).norm() < kBallRadius ? 1.0 : 0.0;
    });
  };
  const Vec3 now(86, 12, 12);
  const Vec3 then(10, 12, 12);
  const LatticeField field = ball_at(now);
  Trail trail{.field = ball_at(then), .transfer_function = ball_look().transfer_function};
  Camera start = default_camera(field.world_bounds(), Space::kNone, "-y");
  start.parallel_projection = true;
  const auto camera_with = [&](const Trail& with) {
    Scene scene(field, ball_look());
    scene.volumes.front().trail = std::make_shared<Trail>(with);
    return framed(start, scene, {.aspect = 4});
  };
  for (const double opacity : {0.9, 0.005}) {
    trail.transfer_function.opacities = {{0.4, 0.0}, {0.6, opacity}};
    const Camera camera = camera_with(trail);
    EXPECT_NEAR(camera.focal_point.x(), 48, 1) << opacity;
    EXPECT_LT(seen_at(camera, then - Vec3(kBallRadius, 0, 0)).x(), -0.8 * 4 * half_height(camera));
    EXPECT_GT(seen_at(camera, then - Vec3(kBallRadius, 0, 0)).x(), -4 * half_height(camera));
  }
  trail.transfer_function.opacities = {{0.4, 0.0}, {0.6, 0.0001}};
  EXPECT_EQ(camera_with(trail).position,
            framed(start, {field, ball_look()}, {.aspect = 4}).position);
}

TEST(Framing, WhereNothingShowsTheCameraStays) {
  Look look = ball_look();
  look.transfer_function.opacities = {{0, 0}};
  const Camera start = default_camera(ball_field().world_bounds());
  const Camera camera = framed(start, {ball_field(), look});
  EXPECT_EQ(camera.position, start.position);
  EXPECT_EQ(camera.focal_point, start.focal_point);
}

TEST(Framing, RefusesWhatItCannotFill) {
  const Camera start = default_camera(ball_field().world_bounds());
  EXPECT_THROW(framed(start, {ball_field(), ball_look()}, {.aspect = 0}), Error);
  EXPECT_THROW(framed(start, {ball_field(), ball_look()}, {.fill = 0}), Error);
  EXPECT_THROW(framed(start, {ball_field(), ball_look()}, {.fill = 1.1}), Error);
  EXPECT_THROW(framed(start, {Field(), ball_look()}), Error);
}

TEST(FirstCamera, FacesPatientsLooksDownOnGroundAndAtTheLongSide) {
  const auto field = [](const Index3& dims, double spacing) {
    return test::make_field(dims, [](std::int64_t, std::int64_t, std::int64_t) { return 1.0; },
                            {.world_from_index = test::scaled_axes(Vec3::Constant(spacing))});
  };
  const auto from = [](const LatticeField& of, Space space) {
    const Camera camera = first_camera(of, of.world_bounds(), space);
    return Vec3((camera.position - camera.focal_point).normalized());
  };
  EXPECT_LT((from(field({20, 20, 20}, 0.9), Space::kLps) - Vec3(0, -1, 0)).norm(), 1e-12);
  EXPECT_LT((from(field({20, 20, 20}, 0.9), Space::kRas) - Vec3(0, 1, 0)).norm(), 1e-12);
  EXPECT_LT((from(field({40, 40, 5}, 1), Space::kNone) - Vec3(0, 0, 1)).norm(), 1e-12);
  EXPECT_LT((from(field({40, 5, 40}, 1), Space::kNone) - Vec3(0, -1, 0)).norm(), 1e-12);
  EXPECT_LT((from(field({5, 40, 40}, 1), Space::kNone) - Vec3(1, 0, 0)).norm(), 1e-12);
  // From the front and the right, above: along a long x more from the front.
  const Vec3 long_x = from(field({40, 20, 20}, 1), Space::kNone);
  const Vec3 long_y = from(field({20, 40, 20}, 1), Space::kNone);
  for (const Vec3& view : {long_x, long_y}) {
    EXPECT_GT(view.x(), 0);
    EXPECT_LT(view.y(), 0);
    EXPECT_NEAR(view.z(), std::sin(20 * std::numbers::pi / 180), 1e-12);
  }
  EXPECT_GT(-long_x.y(), long_x.x());
  EXPECT_GT(long_y.x(), -long_y.y());
}

}  // namespace framing_test
}  // namespace ovoid
