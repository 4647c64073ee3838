// SPDX-License-Identifier: Apache-2.0
#include "view/plan/frame_plan.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "ovoid/error.h"
#include "support/scenes.h"
#include "support/volumes.h"

namespace ovoid::view {
namespace frame_plan_test {

LatticeField stretched_field() {
  test::FieldSetup setup;
  setup.world_from_index = test::scaled_axes(Vec3(0.5, 1, 2));
  return test::constant_field({40, 20, 10}, 1, setup);
}

Camera camera_of(const LatticeField& field, bool is_parallel, double half_height) {
  const Vec3 center = field.world_bounds().center();
  return is_parallel ? test::parallel_camera(center, {0, 0, 1}, half_height)
                     : test::perspective_camera(center, {0, 0, 1}, half_height, 50);
}

// Fails if the order of who may name the unit distance is another.
TEST(FramePlan, UnitDistance) {
  const LatticeField field = stretched_field();
  const Camera camera = camera_of(field, true, 10);
  Look look;
  EXPECT_EQ(LatticePlan(field, camera, look, {}).unit_distance, 0.5);  // the smallest spacing
  look.transfer_function.unit_distance = 3;
  EXPECT_EQ(LatticePlan(field, camera, look, {}).unit_distance, 3);
  look.unit_distance = 7;
  EXPECT_EQ(LatticePlan(field, camera, look, {}).unit_distance, 7);
}

// Pixels 1.5 wide on spacings 0.5, 1, 2; a lattice of 10 slices with sigma 1/2 may widen by 5.
// Fails if an axis' factor is below 1, beyond the lattice's bound, or another axis'.
TEST(FramePlan, WideningByAxis) {
  const LatticeField field = stretched_field();
  RenderOptions options = test::picture(20, 20);
  const LatticePlan plan(field, camera_of(field, true, 15), {}, options);
  EXPECT_EQ(plan.widening(3), Vec3(3, 1.5, 1));
  EXPECT_GE(plan.greatest_widening, 3);
  const LatticePlan far(field, camera_of(field, true, 1e4), {}, options);
  EXPECT_EQ(far.widening(3), Vec3(20, 10, 5));
}

// Fails if sheets that widen no kernel are given the room of those that do.
TEST(FramePlan, NarrowSupport) {
  const LatticeField field = stretched_field();
  const LatticePlan plan(field, camera_of(field, true, 15), {}, test::picture(20, 20));
  const Bounds3 narrow = support_of(field, 1.0, 0.0);
  EXPECT_EQ(plan.narrow_support.min(), narrow.min());
  EXPECT_EQ(plan.narrow_support.max(), narrow.max());
  EXPECT_LT(plan.index_support.min().x(), narrow.min().x() - 0.05);
}

// Fails if perspective widening does not grow with depth, or a sheet's exceeds what was planned
// for.
TEST(FramePlan, WideningByDepth) {
  const LatticeField field = stretched_field();
  const LatticePlan plan(field, camera_of(field, false, 15), {}, test::picture(20, 20));
  ASSERT_LT(plan.sheets.first, plan.sheets.last);
  const Vec3 nearest = plan.widening(plan.sheets.first);
  const Vec3 farthest = plan.widening(plan.sheets.last - 1);
  EXPECT_LT(nearest.x(), farthest.x());
  EXPECT_LE(farthest.maxCoeff(), plan.greatest_widening);
}

// Fails if a plane's distance is not its dot product with the sample's place, in world lengths.
TEST(FramePlan, ClipDistances) {
  const LatticeField field = stretched_field();
  RenderOptions options = test::picture(20, 16);
  options.clip_planes = {{{1, -4, 8}, 27}};  // length 9
  for (const bool is_parallel : {true, false}) {
    const LatticePlan plan(field, camera_of(field, is_parallel, 15), {}, options);
    EXPECT_TRUE(plan.is_clipped);
    const ClipPlane& plane = plan.clip_planes[0];
    EXPECT_NEAR(plane.normal.norm(), 1, 1e-15);
    for (const std::int64_t sheet : {-3, 0, 4}) {
      const Vec3 place = plan.lattice.world_map(sheet).at(3, 11);
      const ClipMap map = plan.clip_distance(plane, sheet);
      EXPECT_NEAR(map.origin + 3 * map.per_x + 11 * map.per_y, (place.dot(Vec3(1, -4, 8)) - 27) / 9,
                  1e-12);
      const Vec3 next = plan.lattice.world_map(sheet + 1).at(3, 11);
      const ClipMap slope = plan.clip_slope(plane);
      const double distance = plan.lattice.sampling_distance();
      EXPECT_NEAR((slope.origin + 3 * slope.per_x + 11 * slope.per_y) * distance,
                  (next - place).dot(plane.normal), 1e-12);
    }
  }
}

// Fails if a frame of endlessly many sheets is begun.
TEST(FramePlan, RefusesTooManySheets) {
  const LatticeField field = stretched_field();
  for (const double distance : {1e-6, 1e-300}) {
    const RenderOptions options = test::picture(8, 8, distance);
    try {
      const LatticePlan plan(field, camera_of(field, true, 10), {}, options);
      FAIL() << "nothing was thrown";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
      EXPECT_EQ(std::string(error.what())
                    .rfind(fmt::format("sampling_distance = {}: gives ", distance), 0),
                0U);
    }
  }
}

// Fails if something is skipped by modes in which every value shows, or when asked not to.
TEST(FramePlan, WhatMayMatter) {
  const LatticeField field = stretched_field();
  const Camera camera = camera_of(field, true, 10);
  Look look;
  look.transfer_function.opacities = {{0, 0}, {2, 0}, {3, 1}};
  look.isovalue = 5;
  const LatticePlan composite(field, camera, look, {});
  ASSERT_TRUE(composite.may_matter);
  EXPECT_FALSE(composite.may_matter(0.0F, 1.9F));
  EXPECT_TRUE(composite.may_matter(1.0F, 2.5F));
  look.mode = Mode::kIsosurface;
  const LatticePlan surface(field, camera, look, {});
  EXPECT_FALSE(surface.may_matter(0.0F, 4.9F));
  EXPECT_TRUE(surface.may_matter(5.0F, 5.0F));
  look.mode = Mode::kXray;
  EXPECT_TRUE(LatticePlan(field, camera, look, {}).may_matter(0.0F, 0.1F));
  RenderOptions thorough;
  thorough.skip_irrelevant = false;
  EXPECT_FALSE(LatticePlan(field, camera, look, thorough).may_matter);
}

}  // namespace frame_plan_test
}  // namespace ovoid::view
