// SPDX-License-Identifier: Apache-2.0
// A turn through 45 degrees is smooth with image-aligned sheets and is not with axis-aligned ones,
// drawn by the same control renderer.
#include "experiments/popping.h"

#include <gtest/gtest.h>

namespace ovoid::experiments {
namespace {

constexpr TurnOptions kTurn{48, 9, {40, 40, 40}};

// One step among its like: what changes is the picture itself, whose change varies by some ten per
// cent from step to step. Fails if sheets are cut along anything but the view.
TEST(Popping, ImageAlignedSheetsDoNot) {
  EXPECT_LT(turn_renderer(kTurn).jump(), 1.3);
  EXPECT_LT(turn_control(Sheets::kImageAligned, kTurn).jump(), 1.3);
}

// The control: if it did not pop, the test above would show nothing. Whole kernels of a slice show
// its values 2 spacings before and behind it along the ray; the next step shows another slice's.
TEST(Popping, AxisAlignedSlicesDo) {
  EXPECT_GT(turn_control(Sheets::kAxisSlices, kTurn).jump(), 2.0);
}

}  // namespace
}  // namespace ovoid::experiments
