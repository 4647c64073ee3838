// SPDX-License-Identifier: Apache-2.0
// Between the world and a picture's pixels, and what the mouse does to a camera. A wrong sign,
// angle or scale in either would let what was taken hold of slip from under the mouse.
#include "hands.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "projection.h"

namespace ovoid::viewer {
namespace hands_test {

// Sums of a few dozen products of numbers up to a thousand, in double precision: 1e-16 of them
// each.
constexpr double kRounding = 1e-10;
constexpr double kWidth = 320;
constexpr double kHeight = 240;
const Vec2 kSize(kWidth, kHeight);

Camera some_camera(bool is_parallel) {
  Camera camera;
  camera.position = Vec3(3, -4, 5);
  camera.focal_point = Vec3(0.5, 0.25, -1);
  camera.view_up = Vec3(0.1, 0.2, 1);
  camera.view_angle = 40;
  camera.parallel_projection = is_parallel;
  camera.parallel_scale = 2.5;
  return camera;
}

// Seen along -z with y up, so that right angles stay right ones.
Camera upright_camera() {
  Camera camera;
  camera.position = Vec3(1, 2, 13);
  camera.focal_point = Vec3(1, 2, 3);
  camera.view_up = Vec3(0, 1, 0);
  return camera;
}

Vec2 pixel_in(const Camera& camera, const Vec3& world) {
  const auto pixel = Projection(camera, kWidth, kHeight).pixel_of(world);
  return pixel ? *pixel : Vec2(HUGE_VAL, HUGE_VAL);
}

// The point of the focal plane under a pixel.
Vec3 point_under(const Camera& camera, const Vec2& pixel) {
  const Projection projection(camera, kWidth, kHeight);
  return projection.world_at(pixel, projection.focal_depth());
}

double distance_of(const Camera& camera) { return (camera.position - camera.focal_point).norm(); }

class HandsOfBoth : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Projections, HandsOfBoth, ::testing::Bool(), [](const auto& chosen) {
  return chosen.param ? "Parallel" : "Perspective";
});

TEST_P(HandsOfBoth, PixelsAndBack) {
  const Projection projection(some_camera(GetParam()), kWidth, kHeight);
  for (const Vec3& world :
       {Vec3(0, 0, 0), Vec3(1, -2, 0.5), Vec3(-3, 2, -4), Vec3(0.5, 0.25, -1)}) {
    const auto pixel = projection.pixel_of(world);
    ASSERT_TRUE(pixel.has_value());
    const Vec3 back = projection.world_at(*pixel, projection.depth_of(world));
    EXPECT_LT((back - world).norm(), kRounding);
    // The pixel's ray goes through it.
    const Vec3 from_origin = world - projection.ray_origin(*pixel);
    const Vec3 direction = projection.ray_direction(*pixel);
    EXPECT_NEAR(direction.norm(), 1, kRounding);
    EXPECT_LT(from_origin.cross(direction).norm(), kRounding);
    EXPECT_GT(from_origin.dot(direction), 0);
  }
}

TEST_P(HandsOfBoth, TheFocalPointIsInTheMiddleAndThePictureAsHighAsTheCameraSays) {
  const Camera camera = some_camera(GetParam());
  const Projection projection(camera, kWidth, kHeight);
  EXPECT_LT((*projection.pixel_of(camera.focal_point) - kSize / 2).norm(), kRounding);
  EXPECT_NEAR(projection.focal_depth(), distance_of(camera), kRounding);
  const double half =
      GetParam() ? camera.parallel_scale
                 : distance_of(camera) * std::tan(camera.view_angle / 360 * std::numbers::pi);
  // Upwards by half the height ends at the upper edge, which is row 0.
  const Vec3 top = camera.focal_point + projection.up() * half;
  EXPECT_LT((*projection.pixel_of(top) - Vec2(kWidth / 2, 0)).norm(), kRounding);
  const Vec3 beside = camera.focal_point + projection.right() * half;
  EXPECT_LT((*projection.pixel_of(beside) - Vec2((kWidth + kHeight) / 2, kHeight / 2)).norm(),
            kRounding);
}

TEST(Hands, BehindTheEyeThereIsNoPixel) {
  const Camera camera = some_camera(false);
  const Vec3 behind = camera.position + (camera.position - camera.focal_point);
  EXPECT_FALSE(Projection(camera, kWidth, kHeight).pixel_of(behind).has_value());
  EXPECT_FALSE(Projection(camera, kWidth, kHeight).pixel_of(camera.position).has_value());
  EXPECT_TRUE(Projection(some_camera(true), kWidth, kHeight).pixel_of(behind).has_value());
}

TEST_P(HandsOfBoth, OrbitKeepsDistanceAndFocalPoint) {
  const Camera before = some_camera(GetParam());
  Camera camera = before;
  for (const Vec2& moved : {Vec2(13, 0), Vec2(0, -29), Vec2(-111, 47), Vec2(500, 300)})
    orbit(camera, moved, kHeight);
  EXPECT_NEAR(distance_of(camera), distance_of(before), kRounding);
  EXPECT_EQ(camera.focal_point, before.focal_point);
  EXPECT_GT((camera.position - before.position).norm(), 0.1);
  EXPECT_NO_THROW(camera.validate());
}

TEST(Hands, OrbitTurnsByHalfATurnOverTheHeight) {
  for (const Vec2& moved : {Vec2(kHeight, 0), Vec2(-kHeight, 0), Vec2(0, kHeight)}) {
    Camera camera = upright_camera();
    orbit(camera, moved, kHeight);
    EXPECT_LT((camera.position - Vec3(1, 2, -7)).norm(), kRounding) << moved.transpose();
  }
  Camera quarter = upright_camera();
  orbit(quarter, Vec2(-kHeight / 2, 0), kHeight);
  EXPECT_LT((quarter.position - Vec3(11, 2, 3)).norm(), kRounding);
}

// What is nearer than the focal point goes with the mouse.
TEST_P(HandsOfBoth, OrbitTurnsTheWorldWithTheMouse) {
  const Camera before = some_camera(GetParam());
  const Vec3 front = before.focal_point + 0.2 * (before.position - before.focal_point);
  for (const Vec2& moved : {Vec2(4, 0), Vec2(-4, 0), Vec2(0, 4), Vec2(0, -4)}) {
    Camera camera = before;
    orbit(camera, moved, kHeight);
    const Vec2 went = pixel_in(camera, front) - pixel_in(before, front);
    EXPECT_GT(went.dot(moved), 0) << moved.transpose();
  }
}

TEST_P(HandsOfBoth, PanKeepsTheFocalPlaneUnderTheMouse) {
  Camera camera = some_camera(GetParam());
  const Vec2 mouse(100, 30);
  const Vec2 moved(37, -51);
  const Vec3 held = point_under(camera, mouse);
  const double distance = distance_of(camera);
  pan(camera, moved, kHeight);
  EXPECT_LT((pixel_in(camera, held) - mouse - moved).norm(), kRounding * kHeight);
  EXPECT_NEAR(distance_of(camera), distance, kRounding);
}

TEST_P(HandsOfBoth, RollGoesAroundTheMiddleWithTheMouse) {
  Camera camera = some_camera(GetParam());
  const Vec2 from = kSize / 2 + Vec2(80, 0);
  const Vec2 to = kSize / 2 + Vec2(0, 80);
  const Vec3 held = point_under(camera, from);
  roll_with(camera, from, to, kSize / 2);
  EXPECT_LT((pixel_in(camera, held) - to).norm(), kRounding * kHeight);
  const Camera before = camera;
  roll_with(camera, kSize / 2, to, kSize / 2);  // from the very middle there is no angle
  EXPECT_EQ(camera.view_up, before.view_up);
}

TEST_P(HandsOfBoth, ZoomKeepsThePointUnderTheCursor) {
  const Vec2 cursor(250, 60);
  for (const double factor : {1.12, 1 / 1.12, 3.0}) {
    Camera camera = some_camera(GetParam());
    const Camera before = camera;
    const Vec3 held = point_under(camera, cursor);
    zoom_to(camera, factor, cursor, kSize, 10);
    EXPECT_LT((pixel_in(camera, held) - cursor).norm(), kRounding * kHeight) << factor;
    if (GetParam())
      EXPECT_NEAR(camera.parallel_scale, before.parallel_scale / factor, kRounding);
    else
      EXPECT_NEAR(distance_of(camera), distance_of(before) / factor, kRounding);
    const Vec3 axis = (before.focal_point - before.position).normalized();
    EXPECT_LT(axis.cross(camera.focal_point - camera.position).norm(), kRounding);
    camera.validate();
  }
}

// However long the wheel is turned.
TEST_P(HandsOfBoth, ZoomEndsAtAMillionth) {
  constexpr double kExtent = 10;
  for (const bool comes_nearer : {true, false}) {
    Camera camera = some_camera(GetParam());
    for (int i = 0; i < 1000; ++i)
      zoom_to(camera, comes_nearer ? 1.12 : 1 / 1.12, kSize / 2, kSize, kExtent);
    const double scale = GetParam() ? camera.parallel_scale : distance_of(camera);
    const double wanted = comes_nearer ? kExtent * 1e-6 : kExtent * 1e6;
    EXPECT_NEAR(scale / wanted, 1, 1e-6);
    EXPECT_NO_THROW(camera.validate());
  }
}

TEST_P(HandsOfBoth, TogglingTheProjectionKeepsTheSizeAtTheFocalPlane) {
  Camera camera = some_camera(GetParam());
  const Vec3 held = point_under(camera, Vec2(10, 200));
  toggle_projection(camera);
  EXPECT_EQ(camera.parallel_projection, !GetParam());
  EXPECT_LT((pixel_in(camera, held) - Vec2(10, 200)).norm(), kRounding * kHeight);
  EXPECT_EQ(camera.focal_point, some_camera(GetParam()).focal_point);
  toggle_projection(camera);
  EXPECT_EQ(camera.parallel_projection, GetParam());
  EXPECT_LT((pixel_in(camera, held) - Vec2(10, 200)).norm(), kRounding * kHeight);
}

}  // namespace hands_test
}  // namespace ovoid::viewer
