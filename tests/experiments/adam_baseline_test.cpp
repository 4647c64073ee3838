// SPDX-License-Identifier: Apache-2.0
// Two ways to refine kernels from one start.
#include "experiments/adam_baseline.h"

#include <gtest/gtest.h>

#include "ovoid/model.h"

namespace ovoid::experiments {
namespace adam_baseline_test {

// Fails if either way moves kernels the wrong way, or they do not begin with the same.
TEST(AdamBaseline, BothWaysComeNearer) {
  MakeOptions small;
  small.count = 2000;
  const RefineComparison found = compare_refinement(
      make_sample("fin", small), {.kernels = 60, .gauss_newton_steps = 2, .adam = {{4, 64, 0.05}}});
  EXPECT_EQ(found.kernels, 60);
  ASSERT_EQ(found.curves.size(), 2U);
  for (const RefineCurve& curve : found.curves) {
    EXPECT_GT(curve.points.front().psnr, found.start) << curve.way;
    EXPECT_GT(curve.points.back().psnr, found.start + 1) << curve.way;
    EXPECT_LT(curve.points.back().psnr, found.start + 25) << curve.way;
  }
  EXPECT_EQ(found.curves[0].points.back().steps, 2);
  EXPECT_EQ(found.curves[1].points.back().steps, 64);
}

}  // namespace adam_baseline_test
}  // namespace ovoid::experiments
