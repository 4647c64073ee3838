// SPDX-License-Identifier: Apache-2.0
// A turn through 45 degrees is smooth with image-aligned sheets and is not with axis-aligned ones,
// drawn by the same control renderer.
#include "experiments/popping.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>

namespace ovoid::experiments {
namespace popping_test {

// A hard look: pictures are edges, and what pops is not hidden in haze.
constexpr int kParts = 4;
constexpr TurnOptions kWhole{96, 7, {40, 40, 40}, 1.0, TurnLook::kHard};
constexpr TurnOptions kPartOfStep{96, 7 * kParts - 1, {40, 40, 40}, 1.0 / kParts, TurnLook::kHard};

// How much more the greatest of all quarter steps changes than it could in a smooth turn. Edges
// move in proportion to the angle, so a quarter step changes a quarter of what a step does, and no
// more than the greatest step. But pixels come and go one by one, and the signal's upright edges,
// left and right, lie along columns of them: two columns at once. What pops changes by the same
// however small the step is.
double excess(const std::function<Turn(const TurnOptions&)>& turn) {
  const Turn parts = turn(kPartOfStep);
  const double smooth = turn(kWhole).greatest() / kParts + 2 * parts.greatest_column;
  ::testing::Test::RecordProperty("greatest", std::to_string(parts.greatest()));
  ::testing::Test::RecordProperty("smooth", std::to_string(smooth));
  return parts.greatest() - smooth;
}

// Fails if sheets are cut along anything but the view, at any of the angles.
TEST(Popping, ImageAlignedSheetsDoNot) {
  EXPECT_LT(excess(turn_renderer), 0);
  EXPECT_LT(excess([](const TurnOptions& options) {
              return turn_control(Sheets::kImageAligned, options);
            }),
            0);
}

// The control: if it did not pop, the test above would show nothing. Whole kernels of a slice show
// its values 2 spacings before and behind it along the ray; the next step shows another slice's.
TEST(Popping, AxisAlignedSlicesDo) {
  EXPECT_GT(
      excess([](const TurnOptions& options) { return turn_control(Sheets::kAxisSlices, options); }),
      0);
}

}  // namespace popping_test
}  // namespace ovoid::experiments
