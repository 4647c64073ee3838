// SPDX-License-Identifier: Apache-2.0
#include "ovoid/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "ovoid/error.h"

namespace ovoid {
namespace camera_test {

// A rotation of vectors of length about 10 errs by a few units in the last place: 10 * 8 * 2^-53 =
// 9e-15.
constexpr double kTolerance = 2e-14;

void expect_near(const Vec3& actual, const Vec3& expected, double tolerance = kTolerance) {
  EXPECT_LE((actual - expected).norm(), tolerance)
      << actual.transpose() << " instead of " << expected.transpose();
}

std::string refusal(const Camera& camera) {
  try {
    camera.validate();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    return error.what();
  }
  return "accepted";
}

// The camera of the worked examples: at (0, 0, 10), looking down -z at the origin, y up; right is
// +x.
Camera front() {
  Camera camera;
  camera.position = {0, 0, 10};
  return camera;
}

// Fails if a motion turns the wrong way round, about the wrong axis, or about the camera instead of
// the focal point.
TEST(Camera, AzimuthTurnsAboutViewUpThroughTheFocalPoint) {
  Camera camera = front();
  camera.azimuth(90);  // right-handed about +y: z goes to x
  expect_near(camera.position, {10, 0, 0});
  expect_near(camera.view_up, {0, 1, 0});

  Camera shifted = front();
  shifted.focal_point = {0, 0, 4};
  shifted.azimuth(-30);
  expect_near(shifted.position, {6 * -0.5, 0, 4 + 6 * std::sqrt(3.0) / 2});
}

TEST(Camera, AzimuthUsesViewUpAsItIs) {
  Camera camera = front();
  camera.view_up = {0, 3,
                    4};  // neither unit length nor orthogonal: VTK turns about it all the same
  camera.azimuth(180);
  // Half a turn about the unit vector u maps p to 2 (u.p) u - p; u = (0, 0.6, 0.8), p = (0, 0, 10).
  expect_near(camera.position, {0, 2 * 8 * 0.6, 2 * 8 * 0.8 - 10});
}

TEST(Camera, PositiveElevationRaisesTheCamera) {
  Camera camera = front();
  camera.elevation(30);
  expect_near(camera.position, {0, 5, 10 * std::sqrt(3.0) / 2});
  expect_near(camera.view_up, {0, std::sqrt(3.0) / 2, -0.5});
}

TEST(Camera, ElevationPassesThePole) {
  Camera camera = front();
  camera.elevation(90);
  expect_near(camera.position, {0, 10, 0});
  expect_near(camera.view_up, {0, 0, -1});
  camera.validate();
  camera.elevation(30);
  expect_near(camera.position, {0, 10 * std::sqrt(3.0) / 2, -5});
}

TEST(Camera, ManySmallElevationsEqualOneLarge) {
  Camera steps = front();
  steps.view_up = {0.3, 1, 0.2};
  Camera once = steps;
  for (int i = 0; i < 100; ++i) steps.elevation(0.7);
  once.elevation(70);
  // A hundred rotations, each within kTolerance.
  expect_near(steps.position, once.position, 100 * kTolerance);
  expect_near(steps.view_up, once.view_up, 100 * kTolerance);
}

TEST(Camera, RollTurnsViewUpAboutTheViewAxis) {
  Camera camera = front();
  camera.roll(90);  // right-handed about -z: y goes to x
  expect_near(camera.view_up, {1, 0, 0});
  expect_near(camera.position, {0, 0, 10});
}

TEST(Camera, ZoomDividesTheAngleOrTheScale) {
  Camera camera;
  camera.parallel_scale = 6;
  camera.zoom(2);
  EXPECT_EQ(camera.view_angle, 15.0);
  EXPECT_EQ(camera.parallel_scale, 6.0);
  camera.parallel_projection = true;
  camera.zoom(1.5);
  EXPECT_EQ(camera.view_angle, 15.0);
  EXPECT_EQ(camera.parallel_scale, 4.0);
  EXPECT_THROW(camera.zoom(0), Error);
  EXPECT_THROW(camera.zoom(-1), Error);
  EXPECT_THROW(camera.zoom(std::numeric_limits<double>::quiet_NaN()), Error);
}

// Fails if a member is not checked, or if the message does not name it.
TEST(Camera, ValidateNamesTheMember) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Camera().validate();

  Camera camera = front();
  camera.position.x() = nan;
  EXPECT_NE(refusal(camera).find("position"), std::string::npos);
  camera = front();
  camera.focal_point = camera.position;
  EXPECT_NE(refusal(camera).find("position = (0, 0, 10)"), std::string::npos);
  camera = front();
  camera.focal_point = {0, std::numeric_limits<double>::infinity(), 0};
  EXPECT_NE(refusal(camera).find("focal_point"), std::string::npos);
  camera = front();
  camera.position = {1e308, -1e308, 1e308};  // finite, but the distance is not
  camera.focal_point = -camera.position;
  EXPECT_NE(refusal(camera).find("finite distance"), std::string::npos);
  for (const Vec3& up : {Vec3(0, 0, 0), Vec3(0, 0, -2), Vec3(0, 1e-8, 1), Vec3(0, nan, 0)}) {
    camera = front();
    camera.view_up = up;
    EXPECT_NE(refusal(camera).find("view_up"), std::string::npos) << up.transpose();
  }
  for (const double scale : {0.0, -1.0, nan, std::numeric_limits<double>::infinity()}) {
    camera = front();
    camera.parallel_scale = scale;
    EXPECT_NE(refusal(camera).find("parallel_scale"), std::string::npos) << scale;
  }
  for (const double angle : {0.0, 180.0, -30.0, nan}) {
    camera = front();
    camera.view_angle = angle;
    EXPECT_NE(refusal(camera).find("view_angle"), std::string::npos) << angle;
  }
}

// ---- default_camera

const Bounds3 kBox(Vec3(-1, -2, 0),
                   Vec3(3, 2, 7));  // centre (1, 0, 3.5), diagonal (4, 4, 7): length 9

TEST(DefaultCamera, IsVtksResetCamera) {
  const Camera camera = default_camera(kBox);
  expect_near(camera.focal_point, {1, 0, 3.5});
  EXPECT_DOUBLE_EQ(camera.parallel_scale, 4.5);
  // 4.5 / sin(15 degrees), with sin(15) = (sqrt(6) - sqrt(2)) / 4.
  const double distance = 4.5 * 4 / (std::sqrt(6.0) - std::sqrt(2.0));
  expect_near(camera.position, {1, 0, 3.5 + distance});
  expect_near(camera.view_up, {0, 1, 0}, 0);
  EXPECT_EQ(camera.view_angle, 30.0);
  EXPECT_FALSE(camera.parallel_projection);
  camera.validate();
  EXPECT_EQ(default_camera(kBox, Space::kNone, "", 2.5).parallel_scale, camera.parallel_scale);
}

// The picture of an upright camera is narrower than high: the sphere must fit the width.
TEST(DefaultCamera, UprightPicturesFitTheWidth) {
  const double aspect = 0.5;
  const Camera camera = default_camera(kBox, Space::kNone, "", aspect);
  EXPECT_DOUBLE_EQ(camera.parallel_scale, 9.0);
  const double distance = (camera.position - camera.focal_point).norm();
  const double half_width_tangent = aspect * std::tan(std::numbers::pi / 12);
  // The cone of the horizontal angle touches the sphere: sin(atan(t)) = t / sqrt(1 + t^2) = radius
  // / distance.
  EXPECT_NEAR(half_width_tangent / std::hypot(1.0, half_width_tangent), 4.5 / distance, 1e-15);
}

TEST(DefaultCamera, ViewsAreSeenFromTheNamedSide) {
  struct Row {
    const char* name;
    Space space;
    Vec3 from, up;
  };
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
  const Row rows[] = {
      {"+x", Space::kNone, x, z},        {"-x", Space::kNone, -x, z},
      {"+y", Space::kNone, y, z},        {"-y", Space::kLps, -y, z},
      {"+z", Space::kRas, z, y},         {"-z", Space::kNone, -z, y},
      {"", Space::kNone, z, y},          {"", Space::kLps, -y, z},
      {"", Space::kRas, y, z},           {"anterior", Space::kLps, -y, z},
      {"anterior", Space::kRas, y, z},   {"posterior", Space::kLps, y, z},
      {"posterior", Space::kRas, -y, z}, {"left", Space::kLps, x, z},
      {"left", Space::kRas, -x, z},      {"right", Space::kLps, -x, z},
      {"right", Space::kRas, x, z},      {"superior", Space::kLps, z, -y},
      {"superior", Space::kRas, z, y},   {"inferior", Space::kLps, -z, -y},
      {"inferior", Space::kRas, -z, y},  {"front", Space::kNone, -y, z},
      {"back", Space::kNone, y, z},      {"left", Space::kNone, -x, z},
      {"right", Space::kNone, x, z},     {"top", Space::kNone, z, y},
      {"bottom", Space::kNone, -z, y},
  };
  for (const Row& row : rows) {
    const Camera camera = default_camera(kBox, row.space, row.name);
    expect_near((camera.position - camera.focal_point).normalized(), row.from, 1e-15);
    expect_near(camera.view_up, row.up, 0);
    camera.validate();
  }
}

TEST(DefaultCamera, RefusesWhatItCannotShow) {
  EXPECT_THROW(default_camera(Bounds3()), Error);
  EXPECT_THROW(
      default_camera(Bounds3(Vec3(0, 0, 0), Vec3(1, 1, std::numeric_limits<double>::infinity()))),
      Error);
  EXPECT_THROW(default_camera(kBox, Space::kNone, "x"), Error);
  EXPECT_THROW(default_camera(kBox, Space::kNone, "anterior"), Error);
  EXPECT_THROW(default_camera(kBox, Space::kLps, "", 0.0), Error);
  EXPECT_THROW(default_camera(kBox, Space::kLps, "", std::numeric_limits<double>::quiet_NaN()),
               Error);
  default_camera(Bounds3(Vec3(1, 2, 3), Vec3(1, 2, 3)))
      .validate();  // a single point is a place to look at
}

// Eight across: of 1e17 and more on, places around them are the same numbers.
TEST(DefaultCamera, RefusesWhatNumbersDoNotTellApart) {
  const auto at = [](double x) { return Bounds3(Vec3(x, 0, 0), Vec3(x + 8, 8, 8)); };
  default_camera(at(1e14)).validate();
  default_camera(Bounds3(Vec3::Zero(), Vec3::Constant(1e100))).validate();
  for (const Bounds3& far :
       {at(1e18), at(1e38), at(1e308), Bounds3(Vec3::Constant(-1e308), Vec3::Constant(1e308))}) {
    try {
      default_camera(far);
      ADD_FAILURE() << "no error at " << far.min().transpose();
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("move the data to the origin"), std::string::npos)
          << error.what();
    }
  }
}

}  // namespace camera_test
}  // namespace ovoid
