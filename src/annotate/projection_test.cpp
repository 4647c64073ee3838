// SPDX-License-Identifier: Apache-2.0
#include "annotate/projection.h"

#include <gtest/gtest.h>

namespace ovoid::annotate {
namespace projection_test {

// From ten units away; a unit at the focal point is 5 pixels of a picture of 100 x 100.
Camera from_z() {
  Camera camera;
  camera.position = {0, 0, 10};
  camera.focal_point = {0, 0, 0};
  camera.view_up = {0, 1, 0};
  camera.view_angle = 90;
  return camera;
}

void expect_line(const Projection& projection, const Vec3& a, const Vec3& b, const Vec2& first,
                 const Vec2& second) {
  const auto line = projection.line(a, b);
  ASSERT_TRUE(line.has_value());
  EXPECT_LT((line->first - first).norm(), 1e-6) << line->first.transpose();
  EXPECT_LT((line->second - second).norm(), 1e-6) << line->second.transpose();
}

// Fails if an end behind the eye is not moved to the near plane, a thousandth of the way to the
// focal point, or the wrong one is.
TEST(Projection, LinesAreCutBeforeTheEye) {
  const Projection projection(from_z(), 100, 100);
  const Vec3 seen(1, 2, 0), behind(1, 2, 20);
  const Vec2 at_seen(55, 40), at_near(50 + 5000, 50 - 10000);
  expect_line(projection, seen, behind, at_seen, at_near);
  expect_line(projection, behind, seen, at_near, at_seen);
  EXPECT_FALSE(projection.line(behind, {3, 3, 15}).has_value());
  EXPECT_NEAR(projection.pixels_per_world_at_focus(), 5, 1e-12);
}

TEST(Projection, ParallelLinesAreWhole) {
  Camera camera = from_z();
  camera.parallel_projection = true;
  camera.parallel_scale = 10;
  expect_line(Projection(camera, 100, 100), {1, 2, 0}, {1, 2, 20}, {55, 40}, {55, 40});
}

}  // namespace projection_test
}  // namespace ovoid::annotate
