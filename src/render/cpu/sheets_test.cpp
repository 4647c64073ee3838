// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/sheets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

namespace ovoid::cpu {
namespace sheets_test {

constexpr PlaneShape kShape{5, 7};

std::vector<float*> planes_of(const Sheet& sheet) {
  return {sheet.values, sheet.colors, sheet.gradient[0], sheet.gradient[1], sheet.gradient[2]};
}

// Fails if planes overlap, or end before a group that begins at the last sample does.
TEST(SheetRing, PlanesHaveRoomForAGroupAtTheirEnd) {
  constexpr int kGroup = 16;
  const int room = kShape.rows * kShape.stride + kGroup - 1;
  ASSERT_LE(static_cast<std::size_t>(room), kShape.num_floats());
  SheetRing ring(kShape);
  float mark = 0;
  for (int s = 0; s < SheetRing::kSheets; ++s) {
    for (float* plane : planes_of(ring[s])) std::fill_n(plane, room, ++mark);
  }
  mark = 0;
  for (int s = 0; s < SheetRing::kSheets; ++s) {
    for (const float* plane : planes_of(ring[s])) {
      ++mark;
      EXPECT_EQ(plane[0], mark);
      EXPECT_EQ(plane[room - 1], mark);
    }
  }
}

// Fails if neighbouring sheets share memory where their numbers change sign: sheets may lie in
// front of the frame's first.
TEST(SheetRing, SheetsGoByTheirNumbers) {
  SheetRing ring(kShape);
  for (std::int64_t first = -9; first < 9; ++first) {
    std::set<const Sheet*> held;
    for (int s = 0; s < SheetRing::kSheets; ++s) held.insert(&ring[first + s]);
    EXPECT_EQ(held.size(), static_cast<std::size_t>(SheetRing::kSheets)) << first;
    EXPECT_EQ(&ring[first], &ring[first + SheetRing::kSheets]) << first;
  }
}

// Fails if a sheet remembers what a block before it knew.
TEST(SheetRing, AClearedSheetKnowsNothing) {
  SheetRing ring(kShape);
  Sheet& sheet = ring[3];
  sheet.defined[2] = sheet.has_gradient[4] = 5;
  sheet.clear();
  EXPECT_EQ(sheet.defined, RowBits{});
  EXPECT_EQ(sheet.has_gradient, RowBits{});
}

}  // namespace sheets_test
}  // namespace ovoid::cpu
