// SPDX-License-Identifier: Apache-2.0
#include "view/plan/kernel_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "ovoid/error.h"

namespace ovoid::view {
namespace kernel_plan_test {

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

// Fails if kernels behind a clip plane are asked for, or those before it are not.
TEST(KernelPlan, ClippedBlocksAreSkipped) {
  const KernelField field = two_balls();
  ASSERT_EQ(field.source().num_bricks(), 2);
  const auto bricks = [&](const ClipPlane& plane, bool is_parallel, bool skips) {
    RenderOptions options = options_of(640);
    options.clip_planes = {plane};
    options.skip_irrelevant = skips;
    return KernelPlan(field, camera_from_z(is_parallel), look_above(0), options).bricks;
  };
  for (const bool is_parallel : {true, false}) {
    for (const double sign : {-1.0, 1.0}) {
      const auto kept = bricks({{2 * sign, 0, 0}, 4 * sign}, is_parallel, true);
      ASSERT_EQ(kept.size(), 1U);
      const double at = field.source().brick(kept[0]).support.center().x();
      EXPECT_GT((at - 2) * sign, 0);
    }
    EXPECT_EQ(bricks({{0, 0, 1}, 5}, is_parallel, true).size(), 0U);
    EXPECT_EQ(bricks({{0, 0, 1}, 0.05}, is_parallel, true).size(), 2U);
    EXPECT_EQ(bricks({{0, 0, 1}, 5}, is_parallel, false).size(), 2U);
  }
}

// Fails if a block is dropped whose last slab, or piece, is not all cut away, or kept when it is.
TEST(KernelPlan, SliversOfSlabsAreKept) {
  const KernelField field = two_balls();
  // How many sheets farther than the last something of a block is drawn.
  const std::pair<Classification, double> ways[] = {{Classification::kSampled, 0.5},
                                                    {Classification::kRefined, 1.0}};
  for (const auto& way : ways) {
    const Classification classification = way.first;
    const double reach = way.second;
    const auto plan_with = [&](const std::vector<ClipPlane>& clip_planes) {
      RenderOptions options = options_of(640);
      options.classification = classification;
      options.clip_planes = clip_planes;
      return KernelPlan(field, camera_from_z(true), look_above(0), options);
    };
    const auto relevant_in_layer = [&](int layer, const std::vector<ClipPlane>& clip_planes) {
      const KernelPlan plan = plan_with(clip_planes);
      const auto begin = plan.is_relevant.begin() + plan.block_index(0, 0, layer);
      return std::count(begin, begin + plan.block_index(0, 0, 1), 1);
    };
    const KernelPlan plan = plan_with({});
    ASSERT_GE(plan.num_blocks[2], 2);
    const double step = plan.lattice.sampling_distance();
    const double last = plan.lattice.depth(plan.sheets.first + kBlockDepth - 1);
    // Keeps what is farther than a depth from the camera, which is at z = 10.
    const auto beyond = [](double depth) { return ClipPlane{{0, 0, -1}, depth - 10}; };
    EXPECT_GT(relevant_in_layer(0, {}), 0);
    EXPECT_EQ(relevant_in_layer(0, {beyond(last + (reach - 0.05) * step)}),
              relevant_in_layer(0, {}));
    EXPECT_EQ(relevant_in_layer(0, {beyond(last + (reach + 0.05) * step)}), 0);
    EXPECT_GT(relevant_in_layer(1, {beyond(last + (reach + 0.05) * step)}), 0);
  }
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

}  // namespace kernel_plan_test
}  // namespace ovoid::view
