// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <random>
#include <tuple>

#include "model/test_datasets.h"
#include "ovoid/surface.h"

namespace ovoid::model {
namespace mesh_surface_test {

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

Dataset boxes_of(const std::vector<Vec3>& centers, const std::vector<double>& edges) {
  Dataset dataset = points_dataset(DatasetKind::kBoxes, centers);
  std::vector<double> sizes;
  for (const double edge : edges) sizes.insert(sizes.end(), 3, edge);
  dataset.box_sizes = array_of_numbers("", 3, sizes);
  return dataset;
}

// Of every triangle: its plane's axis, whether it looks up, and the area; summed.
std::map<std::tuple<int, double, bool>, double> areas_by_plane(const Surface& surface) {
  std::map<std::tuple<int, double, bool>, double> areas;
  for (const Surface::Triangle& triangle : surface.triangles) {
    const auto& [a, b, c] = triangle.corners;
    const Vec3& at = surface.places[a];
    const Vec3 area = 0.5 * (surface.places[b] - at).cross(surface.places[c] - at);
    Eigen::Index axis = 0;
    area.cwiseAbs().maxCoeff(&axis);
    EXPECT_NEAR(area.norm(), std::abs(area[axis]), 1e-12);
    EXPECT_EQ(triangle.normals[0], area.normalized().cast<float>());
    areas[{static_cast<int>(axis), at[axis], area[axis] > 0}] += area.norm();
  }
  return areas;
}

// Boxes of two sizes side by side end where no other goes on: of the large one's face towards the
// eight small ones nothing is left. Fails if inner faces stay or outer ones go.
TEST(MeshSurface, OfBoxesIsWhereAllOfThemEnd) {
  std::vector<Vec3> centers = {{0.5, 0.5, 0.5}};
  std::vector<double> edges = {1};
  for (int i = 0; i < 8; ++i) {
    centers.emplace_back(1.25 + 0.5 * (i % 2), 0.25 + 0.5 * (i / 2 % 2), 0.25 + 0.5 * (i / 4));
    edges.push_back(0.5);
  }
  for (Vec3& center : centers) center += Vec3::Constant(0.1);  // which no float has exactly
  const auto surface = make_surface(boxes_of(centers, edges));
  ASSERT_NE(surface, nullptr);
  EXPECT_EQ(surface->triangles.size(), 2U * (5 + 5 * 4));
  EXPECT_EQ(num_edges(*surface), 4 * (5 + 5 * 4));
  EXPECT_NEAR(area_of(*surface), 10, 0.01);
  EXPECT_TRUE(surface->encloses_mesh());
  EXPECT_EQ(surface->triangles.front().values[0], static_cast<float>(centers[0].x()));
  EXPECT_NEAR(surface->bounds.max().x(), 2.1, 1e-3);
}

// A small box stands out from the middle of a large one's face: around it the face goes on, in
// pieces whose edges are the face's own alone.
TEST(MeshSurface, OfBoxesIsCutWhereASmallerOneStandsOnIt) {
  const auto surface = make_surface(boxes_of({{0, 0, 0}, {0.25, 0.125, 2.5}}, {4, 1}));
  ASSERT_NE(surface, nullptr);
  auto areas = areas_by_plane(*surface);
  EXPECT_NEAR((areas[{2, 2.0, true}]), 16 - 1, 1e-9);
  EXPECT_EQ(areas.count({2, 2.0, false}), 0U);
  EXPECT_NEAR((areas[{2, 3.0, true}]), 1, 1e-9);
  EXPECT_NEAR(area_of(*surface), 6 * 16 + 4, 1e-9);
  // Five faces of each box are whole; of the sixth, pieces have the four sides and no others.
  double length = 0;
  for (const Surface::Triangle& triangle : surface->triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      if ((triangle.edges >> i & 1U) == 0) continue;
      length +=
          (surface->places[triangle.corners[(i + 1) % 3]] - surface->places[triangle.corners[i]])
              .norm();
    }
  }
  EXPECT_NEAR(length, 6 * 4 * 4 + 5 * 4, 1e-9);
}

// Boxes of three sizes at random places on a grid, some of them within others or twice the same:
// at any place of any plane as many faces look up less those that look down as before.
TEST(MeshSurface, OfBoxesAtRandomCancelsPairsAlone) {
  constexpr int kSide = 12;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    std::vector<Vec3> centers;
    std::vector<double> edges;
    // [axis][plane][place along the next][place along the one after]: faces up less those down.
    std::array<std::array<std::array<std::array<int, kSide>, kSide>, kSide + 1>, 3> expected{};
    auto left = expected;
    const auto count = [&](auto& faces, std::size_t axis, std::array<int, 3> at,
                           std::array<int, 2> size, int by) {
      for (int u = 0; u < size[0]; ++u) {
        for (int v = 0; v < size[1]; ++v)
          faces[axis][static_cast<std::size_t>(at[0])][static_cast<std::size_t>(at[1] + u)]
               [static_cast<std::size_t>(at[2] + v)] += by;
      }
    };
    for (int i = 0; i < 60; ++i) {
      const int edge = 1 << (random() % 3);
      std::array<int, 3> at{};
      for (int& a : at) a = edge * static_cast<int>(random() % static_cast<unsigned>(kSide / edge));
      centers.emplace_back(at[0] + 0.5 * edge, at[1] + 0.5 * edge, at[2] + 0.5 * edge);
      edges.push_back(edge);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const int u = at[(axis + 1) % 3];
        const int v = at[(axis + 2) % 3];
        count(expected, axis, {at[axis], u, v}, {edge, edge}, -1);
        count(expected, axis, {at[axis] + edge, u, v}, {edge, edge}, 1);
      }
    }
    const auto surface = make_surface(boxes_of(centers, edges));
    ASSERT_NE(surface, nullptr);
    std::size_t num_opposed = 0;
    for (std::size_t t = 0; t < surface->triangles.size(); t += 2) {  // two are a rectangle
      const auto& [a, b, c] = surface->triangles[t].corners;
      const Vec3 lo = surface->places[a].cwiseMin(surface->places[c]);
      const Vec3 size = surface->places[a].cwiseMax(surface->places[c]) - lo;
      const Eigen::Vector3f& normal = surface->triangles[t].normals[0];
      Eigen::Index axis = 0;
      normal.cwiseAbs().maxCoeff(&axis);
      const auto along = [&](const Vec3& v, Eigen::Index k) {
        return static_cast<int>(std::lround(v[(axis + k) % 3]));
      };
      count(left, static_cast<std::size_t>(axis), {along(lo, 0), along(lo, 1), along(lo, 2)},
            {along(size, 1), along(size, 2)}, normal[axis] > 0 ? 1 : -1);
    }
    EXPECT_EQ(left, expected) << "seed " << seed;
    // And nowhere do two that look at each other stay.
    auto absolute = left;
    for (auto& a : absolute) {
      for (auto& b : a) {
        for (auto& c : b) {
          for (int& d : c) num_opposed += static_cast<std::size_t>(std::abs(d));
        }
      }
    }
    EXPECT_NEAR(area_of(*surface), static_cast<double>(num_opposed), 1e-6) << "seed " << seed;
  }
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

}  // namespace mesh_surface_test
}  // namespace ovoid::model
