// SPDX-License-Identifier: Apache-2.0
// Tubes and balls. Fails if they are not as thick as said, not closed, twisted, or torn where cells
// of one line meet.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "model/test_datasets.h"
#include "ovoid/surface.h"

namespace ovoid::model {
namespace tubes_test {

// The volume within, if all faces look the same way; every side is that of two triangles.
double enclosed_volume(const Surface& surface) {
  double volume = 0;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
  for (const Surface::Triangle& triangle : surface.triangles) {
    std::array<std::uint32_t, 3> corners = triangle.corners;
    const auto at = [&](std::size_t c) { return surface.places[corners[c]]; };
    const Vec3 across = (at(1) - at(0)).cross(at(2) - at(0));
    if (across.dot(triangle.normals[0].cast<double>()) < 0) std::swap(corners[1], corners[2]);
    volume += at(0).dot(at(1).cross(at(2))) / 6;
    for (std::size_t c = 0; c < 3; ++c)
      ++sides[{std::min(corners[c], corners[(c + 1) % 3]),
               std::max(corners[c], corners[(c + 1) % 3])}];
  }
  for (const auto& [side, count] : sides) EXPECT_EQ(count, 2);
  return volume;
}

// A prism of 12 sides has so much of its circle's area.
constexpr double kShareOfCircle = 12 * 0.5 / (2 * std::numbers::pi);  // sin 30 degrees = 0.5

TEST(Tubes, AreAsThickAsSaid) {
  const Dataset line =
      mesh_dataset({{0, 0, 0}, {1, 0, 0}, {5, 0, 0}}, {{CellType::kPolyLine, {0, 1, 2}}});
  const auto surface = make_tubes(line, 0.25);
  ASSERT_NE(surface, nullptr);
  EXPECT_NEAR(enclosed_volume(*surface), 5 * kShareOfCircle * std::numbers::pi * 0.0625, 1e-6);
  EXPECT_EQ(surface->triangles.size(), 12U * 2 * 3);
  for (const Vec3& place : surface->places) {
    EXPECT_TRUE(surface->bounds.contains(place));
    const double from_axis = std::hypot(place.y(), place.z());
    EXPECT_TRUE(std::abs(from_axis - 0.25) < 1e-9 || from_axis < 1e-9);
  }
  // Values are the nodes' x (points_dataset).
  for (const Surface::Triangle& triangle : surface->triangles)
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_FLOAT_EQ(triangle.values[c],
                      static_cast<float>(surface->places[triangle.corners[c]].x()));
}

// A helix: no ring is turned against the one before, so the volume is that of its length.
TEST(Tubes, DoNotTwist) {
  std::vector<Vec3> places;
  std::vector<std::uint32_t> nodes;
  double length = 0;
  for (int i = 0; i < 200; ++i) {
    const double turn = 0.1 * i;
    places.emplace_back(std::cos(turn), std::sin(turn), 0.05 * turn);
    nodes.push_back(static_cast<std::uint32_t>(i));
    if (i > 0) length += (places[nodes.size() - 1] - places[nodes.size() - 2]).norm();
  }
  const auto surface = make_tubes(mesh_dataset(places, {{CellType::kPolyLine, nodes}}), 0.02);
  ASSERT_NE(surface, nullptr);
  const double expected = length * kShareOfCircle * std::numbers::pi * 0.0004;
  EXPECT_NEAR(enclosed_volume(*surface), expected, 0.01 * expected);
}

TEST(Tubes, OfCellsThatGoOnAreOne) {
  const std::vector<Vec3> places{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {5, 5, 5}, {6, 5, 5}};
  const auto apart = make_tubes(mesh_dataset(places, {{CellType::kLine, {0, 1}},
                                                      {CellType::kLine, {1, 2}},
                                                      {CellType::kLine, {3, 4}}}),
                                0.1);
  const auto whole = make_tubes(
      mesh_dataset(places, {{CellType::kPolyLine, {0, 1, 2}}, {CellType::kPolyLine, {3, 4}}}), 0.1);
  ASSERT_NE(apart, nullptr);
  ASSERT_EQ(apart->places.size(), whole->places.size());
  for (std::size_t i = 0; i < apart->places.size(); ++i)
    EXPECT_EQ(apart->places[i], whole->places[i]);
}

TEST(Tubes, PointsAreBalls) {
  const auto surface =
      make_tubes(points_dataset(DatasetKind::kParticles, {{1, 2, 3}, {9, 2, 3}}), 0.5);
  ASSERT_NE(surface, nullptr);
  EXPECT_EQ(surface->triangles.size(), 2U * 288);
  for (const Vec3& place : surface->places)
    EXPECT_NEAR(std::min((place - Vec3(1, 2, 3)).norm(), (place - Vec3(9, 2, 3)).norm()), 0.5,
                1e-9);
}

// Nothing of what is nowhere, or has no length.
TEST(Tubes, LeaveOutWhatHasNoPlace) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Vec3> places{{0, 0, 0}, {1, 0, 0}, {nan, 0, 0},
                                 {3, 0, 0}, {3, 0, 0}, {4, 0, 0}};
  const auto surface =
      make_tubes(mesh_dataset(places, {{CellType::kPolyLine, {0, 1, 2, 3, 4, 5}}}), 0.1);
  ASSERT_NE(surface, nullptr);
  for (const Vec3& place : surface->places) EXPECT_TRUE(place.allFinite());
  EXPECT_EQ(surface->triangles.size(), 2U * 12 * 2 * 2);  // from 0 to 1, and from 3 to 4
}

TEST(Tubes, WhatHasNoneAndWhatIsRefused) {
  const Dataset triangle =
      mesh_dataset({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{CellType::kTriangle, {0, 1, 2}}});
  EXPECT_EQ(make_tubes(triangle, 1), nullptr);
  EXPECT_THROW(make_tubes(triangle, -1), Error);
  EXPECT_THROW(make_tubes(triangle, std::numeric_limits<double>::infinity()), Error);
}

}  // namespace tubes_test
}  // namespace ovoid::model
