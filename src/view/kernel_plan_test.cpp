// SPDX-License-Identifier: Apache-2.0
#include "view/kernel_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "ovoid/error.h"

namespace ovoid::view {
namespace {

// Two balls 4 apart along x, of values 1 and 9, and of such sizes that each has a brick of its own.
KernelField two_balls() {
  const std::vector<double> centers{0, 0, 0, 4, 0, 0};
  const std::vector<float> shapes{0.1F, 0.02F};
  const std::vector<float> weights{63.0F, 7900.0F};
  const std::vector<float> values{1, 9};
  KernelColumns columns;
  columns.centers = centers;
  columns.shapes = shapes;
  columns.weights = weights;
  columns.values = {values};
  columns.attributes = {{"value", "", {}}};
  return {make_kernel_source(columns), Reconstruction::kNormalized};
}

Camera camera_from_z(bool is_parallel) {
  Camera camera;
  camera.position = Vec3(2, 0, 10);
  camera.focal_point = Vec3(2, 0, 0);
  camera.parallel_projection = is_parallel;
  camera.parallel_scale = 3;
  return camera;
}

Look look_above(double least) {
  Look look;
  look.transfer_function.colors = {{0, {1, 1, 1}}, {10, {1, 1, 1}}};
  look.transfer_function.opacities = {{least, 0}, {10, 1}};
  return look;
}

RenderOptions options_of(int side) {
  RenderOptions options;
  options.width = options.height = side;
  return options;
}

// Fails if a block that a kernel reaches is left out, or one without any is kept.
TEST(KernelPlan, BlocksThatKernelsReach) {
  for (const bool is_parallel : {true, false}) {
    const KernelField field = two_balls();
    const KernelPlan plan(field, camera_from_z(is_parallel), look_above(0), options_of(640));
    ASSERT_EQ(plan.num_blocks[0], 10);
    std::int64_t in_sight = 0;
    for (int x = 0; x < 10; ++x) {
      bool any = false;
      for (int s = 0; s < plan.num_blocks[2]; ++s) {
        for (int y = 0; y < 10; ++y)
          any |= plan.is_relevant[static_cast<std::size_t>(plan.block_index(x, y, s))] != 0;
      }
      in_sight += any ? 1 : 0;
      // The middle columns lie between the balls.
      if (x == 4 || x == 5) {
        EXPECT_FALSE(any) << x;
      }
    }
    EXPECT_GE(in_sight, 2);
    EXPECT_LE(in_sight, 6);
  }
}

// What cannot be seen needs no bricks.
TEST(KernelPlan, ValuesWithoutOpacityAreSkipped) {
  const KernelField field = two_balls();
  const auto bricks = [&](double least) {
    return KernelPlan(field, camera_from_z(true), look_above(least), options_of(640)).bricks.size();
  };
  EXPECT_EQ(bricks(0.0), static_cast<std::size_t>(field.source().num_bricks()));
  EXPECT_EQ(bricks(9.5), 0U);
}

TEST(KernelPlan, RefusesMoreBlocksThanItCanKeep) {
  const KernelField field = two_balls();
  RenderOptions options = options_of(16384);
  options.sampling_distance = 2e-6;
  try {
    const KernelPlan plan(field, camera_from_z(true), look_above(0), options);
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("sampling_distance = 2e-06"));
  }
}

}  // namespace
}  // namespace ovoid::view
