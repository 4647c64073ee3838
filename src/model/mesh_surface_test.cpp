// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "model/test_datasets.h"
#include "ovoid/surface.h"

namespace ovoid::model {
namespace {

double area_of(const Surface& surface) {
  double area = 0;
  for (const Surface::Triangle& triangle : surface.triangles) {
    const auto& [a, b, c] = triangle.corners;
    const Vec3& at = surface.places[a];
    area += 0.5 * (surface.places[b] - at).cross(surface.places[c] - at).norm();
  }
  return area;
}

int num_edges(const Surface& surface) {
  int count = 0;
  for (const Surface::Triangle& triangle : surface.triangles)
    count += std::popcount(static_cast<unsigned>(triangle.edges));
  return count;
}

// Fails if inner faces stay, outer ones go, or a face is cut along its sides.
TEST(MeshSurface, OfAGridIsItsBox) {
  const Dataset grid = grid_dataset({4, 3, 5}, [](const Vec3& at) { return at; });
  const auto surface = make_surface(grid);
  ASSERT_NE(surface, nullptr);
  const int num_faces = 2 * (3 * 2 + 2 * 4 + 3 * 4);
  EXPECT_EQ(surface->triangles.size(), 2U * num_faces);
  EXPECT_NEAR(area_of(*surface), num_faces, 1e-9);
  EXPECT_EQ(num_edges(*surface), 4 * num_faces);
  EXPECT_EQ(surface->bounds.min(), Vec3(0, 0, 0));
  EXPECT_EQ(surface->bounds.max(), Vec3(3, 2, 4));
  // A box has edges: normals are those of its sides.
  for (const Surface::Triangle& triangle : surface->triangles) {
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(triangle.normals[c].cwiseAbs().maxCoeff(), 1, 1e-6);
      EXPECT_EQ(triangle.values[c], static_cast<float>(surface->places[triangle.corners[c]].x()));
    }
  }
}

// What is round has the normals of what it stands for.
TEST(MeshSurface, RoundOnesHaveRoundNormals) {
  const Dataset shell = grid_dataset({2, 48, 8}, [](const Vec3& at) {
    const double turn = at.y() * 2 * std::acos(-1.0) / 48;
    const double radius = 1 + 0.1 * at.x();
    return Vec3(radius * std::cos(turn), radius * std::sin(turn), 0.2 * at.z());
  });
  const auto surface = make_surface(shell);
  int num_round = 0;
  for (const Surface::Triangle& triangle : surface->triangles) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3 place = surface->places[triangle.corners[c]];
      const Vec3 normal = triangle.normals[c].cast<double>();
      if (std::abs(normal.z()) > 0.5 || place.z() < 0.1 || place.z() > 1.3) continue;
      if (std::abs(std::atan2(place.y(), place.x())) < 0.3) continue;  // where it is open
      const Vec3 outward = Vec3(place.x(), place.y(), 0).normalized();
      EXPECT_GT(std::abs(normal.dot(outward)), 0.999);
      ++num_round;
    }
  }
  EXPECT_GT(num_round, 1000);
}

// Two tetrahedra that share a face, one of them inside out, and a triangle by itself.
TEST(MeshSurface, CellsInsideOutAndFlatOnes) {
  const std::vector<Vec3> points = {{0, 0, 0},  {1, 0, 0}, {0, 1, 0}, {0, 0, 1},
                                    {0, 0, -1}, {5, 0, 0}, {6, 0, 0}, {5, 1, 0}};
  const Dataset mesh = mesh_dataset(points, {{CellType::kTetrahedron, {0, 1, 2, 3}},
                                             {CellType::kTetrahedron, {0, 1, 2, 4}},
                                             {CellType::kTriangle, {5, 6, 7}},
                                             {CellType::kLine, {0, 5}}});
  const auto surface = make_surface(mesh);
  ASSERT_NE(surface, nullptr);
  EXPECT_EQ(surface->triangles.size(), 7U);
}

// Cells of different nodes at the same places touch: there is no face between them.
TEST(MeshSurface, NodesOfOnePlaceAreOne) {
  const std::vector<Vec3> points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1},
                                    {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, -1}};
  const Dataset mesh = mesh_dataset(
      points, {{CellType::kTetrahedron, {0, 1, 2, 3}}, {CellType::kTetrahedron, {4, 6, 5, 7}}});
  EXPECT_EQ(make_surface(mesh)->triangles.size(), 6U);
}

// Boxes of two sizes side by side: faces within a size are shared, those where sizes meet are not.
TEST(MeshSurface, OfBoxesIsWhereTheyEndAndWhereSizesMeet) {
  std::vector<Vec3> centers = {{0.5, 0.5, 0.5}};
  std::vector<double> edges = {1, 1, 1};
  for (int i = 0; i < 8; ++i) {
    centers.emplace_back(1.25 + 0.5 * (i % 2), 0.25 + 0.5 * (i / 2 % 2), 0.25 + 0.5 * (i / 4));
    edges.insert(edges.end(), {0.5, 0.5, 0.5});
  }
  for (Vec3& center : centers) center += Vec3::Constant(0.1);  // which no float has exactly
  Dataset dataset = points_dataset(DatasetKind::kBoxes, centers);
  dataset.box_sizes = array_of_numbers("", 3, edges);
  const auto surface = make_surface(dataset);
  ASSERT_NE(surface, nullptr);
  EXPECT_EQ(surface->triangles.size(), 2U * (6 + 6 * 4));
  EXPECT_NEAR(area_of(*surface), 12, 0.01);
  EXPECT_TRUE(surface->encloses_mesh());
  EXPECT_EQ(surface->triangles.front().values[0], static_cast<float>(centers[0].x()));
}

// Seen from outside corners go counterclockwise, whatever the cells' own order.
TEST(MeshSurface, FacesAreTurnedOutwards) {
  const std::vector<Vec3> points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (const std::uint32_t first : {1U, 2U}) {
    const auto surface =
        make_surface(mesh_dataset(points, {{CellType::kTetrahedron, {0, first, 3 - first, 3}}}));
    ASSERT_EQ(surface->triangles.size(), 4U);
    for (const Surface::Triangle& triangle : surface->triangles) {
      const auto& [a, b, c] = triangle.corners;
      const Vec3& at = surface->places[a];
      const Vec3 normal = (surface->places[b] - at).cross(surface->places[c] - at);
      EXPECT_GT(normal.dot(at - Vec3::Constant(0.25)), 0);
      EXPECT_TRUE(triangle.is_boundary);
    }
  }
}

TEST(MeshSurface, KnowsWhetherItEnclosesTheMesh) {
  const std::vector<Vec3> points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const auto solid =
      std::pair<CellType, std::vector<std::uint32_t>>{CellType::kTetrahedron, {0, 1, 2, 3}};
  EXPECT_TRUE(make_surface(mesh_dataset(points, {solid}))->encloses_mesh());
  EXPECT_FALSE(make_surface(mesh_dataset(points, {solid, {CellType::kOther, {0, 1, 2, 3}}}))
                   ->encloses_mesh());
  EXPECT_FALSE(
      make_surface(mesh_dataset(points, {{CellType::kTriangle, {0, 1, 2}}}))->encloses_mesh());
}

TEST(MeshSurface, CellsGiveTheirOwnValues) {
  Dataset grid = grid_dataset({3, 2, 2}, [](const Vec3& at) { return at; });
  grid.arrays = {array_of_numbers("c", 1, std::vector<float>{7, 9})};
  grid.arrays[0].is_cell_data = true;
  const auto surface = make_surface(grid);
  for (const Surface::Triangle& triangle : surface->triangles) {
    double middle = 0;
    for (const std::uint32_t corner : triangle.corners) middle += surface->places[corner].x() / 3;
    const float expected = middle < 1 ? 7.0F : 9.0F;
    for (const float value : triangle.values) EXPECT_EQ(value, expected);
  }
}

TEST(MeshSurface, ColorArraysGiveTheColour) {
  Dataset grid = grid_dataset({2, 2, 2}, [](const Vec3& at) { return at; });
  grid.arrays.push_back(array_of_numbers("w", 1, std::vector<float>(8, 3.0F)));
  KernelModelOptions options;
  options.array = "v";
  options.color_array = "w";
  const auto surface = make_surface(grid, options);
  for (const Surface::Triangle& triangle : surface->triangles)
    for (const float value : triangle.values) EXPECT_EQ(value, 3.0F);
}

TEST(MeshSurface, WhatHasNoFacesHasNone) {
  EXPECT_EQ(make_surface(points_dataset(DatasetKind::kParticles, {{0, 0, 0}, {1, 0, 0}})), nullptr);
  const std::vector<Vec3> points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  EXPECT_EQ(make_surface(mesh_dataset(points, {{CellType::kLine, {0, 1}}})), nullptr);
  EXPECT_EQ(make_surface(mesh_dataset(points, {{CellType::kOther, {0, 1, 2, 3}}})), nullptr);
  // Cells without extent, and nodes without a place.
  EXPECT_EQ(make_surface(mesh_dataset(points, {{CellType::kTriangle, {0, 1, 1}}})), nullptr);
  std::vector<Vec3> broken = points;
  broken[3].z() = NAN;
  const auto surface = make_surface(mesh_dataset(broken, {{CellType::kTetrahedron, {0, 1, 2, 3}}}));
  ASSERT_NE(surface, nullptr);
  EXPECT_EQ(surface->triangles.size(), 1U);
}

TEST(MeshSurface, StopsWhenAsked) {
  std::stop_source stop;
  stop.request_stop();
  const Dataset grid = grid_dataset({3, 3, 3}, [](const Vec3& at) { return at; });
  EXPECT_THROW(make_surface(grid, {}, stop.get_token()), Error);
}

}  // namespace
}  // namespace ovoid::model
