// SPDX-License-Identifier: Apache-2.0
// What would make these fail: a height far from its plane, more planes than there may be, two
// heights in one plane that are not told, ends that move.
#include "io/dicom/even_planes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace ovoid::io {
namespace even_planes_test {

using testing::ElementsAre;

constexpr double kTolerance = 0.1;

EvenPlanes find(const std::vector<double>& heights) {
  return find_even_planes(heights, kTolerance);
}

TEST(EvenPlanes, EvenHeightsHaveAPlaneEach) {
  const EvenPlanes even = find({5, 8, 11, 14});
  EXPECT_TRUE(even.is_usual);
  EXPECT_THAT(even.planes, ElementsAre(0, 1, 2, 3));
  EXPECT_DOUBLE_EQ(even.distance, 3);
  EXPECT_LT(even.worst, 1e-12);
}

TEST(EvenPlanes, GapsAreEmptyPlanes) {
  EXPECT_THAT(find({0, 3, 6, 15, 18}).planes, ElementsAre(0, 1, 2, 5, 6));
  EXPECT_THAT(find({0, 5, 10, 50}).planes, ElementsAre(0, 1, 2, 10));
}

TEST(EvenPlanes, RoundedHeightsAreEven) {
  // 0.625 apart, written with one digit.
  std::vector<double> heights;
  for (int i = 0; i < 80; ++i) heights.push_back(std::round(6.25 * i) / 10);
  const EvenPlanes even = find(heights);
  EXPECT_TRUE(even.is_usual);
  EXPECT_EQ(even.count(), 80);
}

TEST(EvenPlanes, TwoDistancesShareAPart) {
  const EvenPlanes even = find({0, 5, 10, 15, 22.5, 30, 37.5, 45});
  EXPECT_FALSE(even.is_usual);
  EXPECT_DOUBLE_EQ(even.distance, 2.5);
  EXPECT_THAT(even.planes, ElementsAre(0, 2, 4, 6, 9, 12, 15, 18));
  EXPECT_THAT(find({0, 3, 6, 11, 16}).planes, ElementsAre(0, 3, 6, 11, 16));
}

TEST(EvenPlanes, WhatSharesNoneIsNearAPlane) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> distance(1, 3);
  std::vector<double> heights{0};
  for (int i = 0; i < 99; ++i) heights.push_back(heights.back() + distance(random));
  const EvenPlanes even = find(heights);
  EXPECT_LE(even.count(), 400);
  EXPECT_LE(even.worst, 0.51 * even.distance);
  EXPECT_LT(even.distance, 0.6);
  EXPECT_TRUE(std::is_sorted(even.planes.begin(), even.planes.end()));
  EXPECT_EQ(std::count(even.planes.begin(), even.planes.end(), EvenPlanes::kLeftOut), 0);
}

// No file makes a volume as large as it likes.
TEST(EvenPlanes, WhatNeedsTooManyPlanesLosesSome) {
  const EvenPlanes even = find({0, 1e-6, 1e6, 1e6 + 1e-6, 2e6});
  EXPECT_EQ(even.count(), 1024);
  EXPECT_EQ(std::count(even.planes.begin(), even.planes.end(), EvenPlanes::kLeftOut), 2);
  EXPECT_EQ(even.planes.front(), 0);
  for (const double top : {1e12, 1e30}) EXPECT_LE(find({0, 1e-12, top}).count(), 1024);
}

}  // namespace even_planes_test
}  // namespace ovoid::io
