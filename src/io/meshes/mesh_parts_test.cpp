// SPDX-License-Identifier: Apache-2.0
#include "io/meshes/mesh_parts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "io/images/test_volumes.h"

namespace ovoid::io {
namespace mesh_parts_test {

DataArray places(const std::vector<float>& values) {
  return make_array("positions", ScalarType::kFloat32, values, 3);
}

DataArray cell_array(const std::string& name, const std::vector<float>& values) {
  DataArray array = make_array(name, ScalarType::kFloat32, values);
  array.is_cell_data = true;
  return array;
}

DataArray flags(const std::vector<std::uint8_t>& values, bool is_cell_data) {
  DataArray array = make_array("vtkGhostType", ScalarType::kUInt8, values);
  array.is_cell_data = is_cell_data;
  return array;
}

// Two lines from x to x + 1 and on to x + 2.
MeshPart lines_from(float x) {
  MeshPart part;
  part.positions = places({x, 0, 0, x + 1, 0, 0, x + 2, 0, 0});
  part.cells.types = {CellType::kLine, CellType::kLine};
  part.cells.offsets = {0, 2, 4};
  part.cells.connectivity = {0, 1, 1, 2};
  part.arrays = {make_array("v", ScalarType::kFloat32, std::vector<float>{x, x + 1, x + 2}),
                 cell_array("c", {x, x + 1})};
  return part;
}

Dataset named() {
  Dataset dataset;
  dataset.source = "a.vtu";
  dataset.format = "VTU";
  return dataset;
}

std::string check_error(const MeshPart& part) {
  return error_of([&] { check_mesh("a.vtu", part); });
}

TEST(MeshParts, WhatAFileClaimsIsChecked) {
  EXPECT_EQ(check_error(lines_from(0)), "");
  MeshPart part = lines_from(0);
  part.cells.connectivity = {0, 1, 1, 3};
  EXPECT_EQ(check_error(part),
            "file-format: a.vtu: cells: connectivity[3] = 3: the mesh has 3 nodes");
  part = lines_from(0);
  part.cells.offsets = {0, 5, 4};
  EXPECT_EQ(check_error(part), "file-format: a.vtu: cells: offsets[1] = 5: expected 0 to 4");
  part.cells.offsets = {0, 1, 4};
  EXPECT_EQ(check_error(part), "file-format: a.vtu: cells: cell 0 has 1 nodes: its type needs 2");
  part.cells.offsets = {0, 4};
  EXPECT_EQ(check_error(part),
            "file-format: a.vtu: cells: 2 offsets for 2 types: expected one more, from 0");
  part = lines_from(0);
  part.arrays[1].num_tuples = 3;
  EXPECT_EQ(check_error(part), "file-format: a.vtu: array 'c': 3 tuples: the mesh has 2 cells");
  part = lines_from(0);
  part.positions = places({0, 0, 0, 1, NAN, 0, 2, 0, 0});
  EXPECT_EQ(check_error(part),
            "file-format: a.vtu: points: point 1 has y = nan: expected a finite number");
  part = lines_from(0);
  part.cells = {};
  part.cells.dims = {2, 2, 1};
  EXPECT_EQ(check_error(part),
            "file-format: a.vtu: has 3 points, dimensions 2x2x1 need another number");
  EXPECT_EQ(check_error(MeshPart{}), "file-format: a.vtu: has no points");
}

// Every cell of a structured mesh as VTK orders its corners, whichever axes are flat.
TEST(MeshParts, StructuredCellsBecomeExplicit) {
  MeshPart part;
  part.cells.dims = {3, 2, 2};
  make_explicit(part);
  EXPECT_EQ(part.cells.types, (std::vector{CellType::kHexahedron, CellType::kHexahedron}));
  EXPECT_EQ(part.cells.offsets, (std::vector<std::int64_t>{0, 8, 16}));
  EXPECT_EQ(part.cells.connectivity, (std::vector<std::uint32_t>{0, 1, 4, 3, 6, 7, 10, 9,  //
                                                                 1, 2, 5, 4, 7, 8, 11, 10}));
  part.cells = {};
  part.cells.dims = {2, 1, 2};
  make_explicit(part);
  EXPECT_EQ(part.cells.types, std::vector{CellType::kQuad});
  EXPECT_EQ(part.cells.connectivity, (std::vector<std::uint32_t>{0, 1, 3, 2}));
}

TEST(MeshParts, HiddenAndDuplicateCellsAreDropped) {
  MeshPart part = lines_from(0);
  part.arrays.push_back(flags({0, 1}, true));  // a duplicate
  EXPECT_EQ(drop_ghosts(part), 1);
  EXPECT_EQ(part.cells.connectivity, (std::vector<std::uint32_t>{0, 1}));
  ASSERT_EQ(part.arrays.size(), 2U);
  EXPECT_EQ(values_of<float>(part.arrays[1]), std::vector<float>{0});
  EXPECT_EQ(part.num_nodes(), 3);  // the one without a cell stays

  part = lines_from(0);
  part.arrays.push_back(flags({2, 0, 1}, false));  // hidden; duplicates belong to cells of ours
  EXPECT_EQ(drop_ghosts(part), 1);
  EXPECT_EQ(part.cells.connectivity, (std::vector<std::uint32_t>{1, 2}));

  MeshPart points = lines_from(0);
  points.cells = {};
  points.arrays.pop_back();
  points.arrays.push_back(flags({0, 1, 2}, false));
  EXPECT_EQ(drop_ghosts(points), 2);
  EXPECT_EQ(points.num_nodes(), 1);
  EXPECT_EQ(values_of<float>(points.arrays[0]), std::vector<float>{0});

  // Structured cells with a hidden node become explicit.
  MeshPart grid;
  grid.cells.dims = {3, 1, 1};
  grid.positions = places({0, 0, 0, 1, 0, 0, 2, 0, 0});
  grid.arrays = {flags({2, 0, 0}, false)};
  EXPECT_EQ(drop_ghosts(grid), 1);
  EXPECT_EQ(grid.cells.types, std::vector{CellType::kLine});
  EXPECT_EQ(grid.cells.connectivity, (std::vector<std::uint32_t>{1, 2}));
}

TEST(MeshParts, NothingVisibleIsAnError) {
  MeshPart part = lines_from(0);
  part.arrays.push_back(flags({1, 32}, true));
  EXPECT_EQ(error_of([&] { mesh_of_parts(named(), {part}, {}); }),
            "file-format: a.vtu: all 2 cells or points are hidden or duplicates of other pieces'");
  EXPECT_EQ(error_of([&] { mesh_of_parts(named(), {MeshPart{}}, {}); }),
            "file-format: a.vtu: has no points");
}

// A mesh before the run has cells and no results: its surface can be seen.
TEST(MeshParts, MeshesWithoutArraysHaveZeros) {
  MeshPart part = lines_from(0);
  part.arrays.clear();
  const Dataset mesh = mesh_of_parts(named(), {part}, {});
  EXPECT_EQ(mesh.kind, DatasetKind::kMesh);
  ASSERT_EQ(mesh.arrays.size(), 1U);
  EXPECT_EQ(values_of<float>(mesh.array("nothing")), (std::vector<float>{0, 0, 0}));
  EXPECT_EQ(mesh.notes,
            std::vector<std::string>{"a.vtu: has no array of numbers at its points or cells: its "
                                     "surface can be drawn, without values"});
  ReadOptions options;
  options.array = "v";
  EXPECT_EQ(
      error_of([&] { mesh_of_parts(named(), {part}, options); }),
      "invalid-argument: a.vtu: array 'v': not there: the mesh has no array of numbers at its "
      "points or cells");
}

TEST(MeshParts, PiecesShareTheNodesBetweenThem) {
  // The second piece begins where the first ends, at -0 in y.
  MeshPart second = lines_from(2);
  second.positions = places({2, -0.0F, 0, 3, 0, 0, 4, 0, 0});
  const Dataset mesh = mesh_of_parts(named(), {lines_from(0), second}, {});
  EXPECT_EQ(mesh.kind, DatasetKind::kMesh);
  EXPECT_EQ(mesh.num_positions(), 5);
  EXPECT_EQ(mesh.cells.connectivity, (std::vector<std::uint32_t>{0, 1, 1, 2, 2, 3, 3, 4}));
  EXPECT_EQ(mesh.cells.offsets, (std::vector<std::int64_t>{0, 2, 4, 6, 8}));
  EXPECT_EQ(values_of<float>(mesh.array("v")), (std::vector<float>{0, 1, 2, 3, 4}));
  EXPECT_EQ(values_of<float>(mesh.array("c")), (std::vector<float>{0, 1, 2, 3}));
  EXPECT_EQ(mesh.notes,
            std::vector<std::string>{"a.vtu: 1 points at places of other pieces are merged"});
  EXPECT_TRUE(mesh.blocks.empty());

  // The two sides of a crack within one piece stay apart.
  MeshPart crack = lines_from(0);
  crack.positions = places({7, 0, 0, 8, 0, 0, 8, 0, 0});
  EXPECT_EQ(mesh_of_parts(named(), {lines_from(0), crack}, {}).num_positions(), 6);
}

TEST(MeshParts, BlocksAreMergedOrChosen) {
  MeshPart a = lines_from(0), b = lines_from(2);
  a.block = "wood";
  b.block = "iron";
  const Dataset both = mesh_of_parts(named(), {a, b}, {});
  ASSERT_EQ(both.blocks.size(), 2U);
  EXPECT_EQ(both.blocks[1].name, "iron");
  EXPECT_EQ(both.blocks[1].description, "3 points, 2 cells");
  EXPECT_EQ(both.block, "");
  EXPECT_EQ(both.cells.count(), 4);

  ReadOptions options;
  options.block = "iron";
  const Dataset one = mesh_of_parts(named(), {a, b}, options);
  EXPECT_EQ(one.block, "iron");
  EXPECT_EQ(values_of<float>(one.array("v")), (std::vector<float>{2, 3, 4}));
  options.block = "tin";
  EXPECT_EQ(error_of([&] {
              mesh_of_parts(named(), {a, b}, options);
            }),
            "invalid-argument: a.vtu: block 'tin': not there: expected one of 'wood', 'iron'");

  // An array that one block lacks is left out; without a common one, the largest block is read.
  b.arrays[0].name = "w";
  const Dataset rest = mesh_of_parts(named(), {a, b}, {});
  ASSERT_EQ(rest.arrays.size(), 1U);
  EXPECT_EQ(rest.arrays[0].name, "c");
  b.arrays[1].name = "d";
  b.cells.types = {CellType::kLine, CellType::kLine, CellType::kVertex};
  b.cells.offsets = {0, 2, 4, 5};
  b.cells.connectivity = {0, 1, 1, 2, 0};
  b.arrays[1] = cell_array("d", {1, 2, 3});
  const Dataset largest = mesh_of_parts(named(), {a, b}, {});
  EXPECT_EQ(largest.block, "iron");
  EXPECT_EQ(largest.arrays.size(), 2U);
  EXPECT_EQ(largest.notes.back(),
            "a.vtu: its 2 blocks share no array: 'iron' is read, as it has most to show; choose "
            "with --block");
}

// Fails if a set of nodes, which is larger than the mesh and says nothing, is what is seen.
TEST(MeshParts, BlocksWithCellsOfAVolumeAndArraysComeFirst) {
  const auto tetrahedron = [](const std::string& block, float first) {
    MeshPart part;
    part.block = block;
    part.positions = places({first, 0, 0, first + 1, 0, 0, first, 1, 0, first, 0, 1});
    part.cells.types = {CellType::kTetrahedron};
    part.cells.offsets = {0, 4};
    part.cells.connectivity = {0, 1, 2, 3};
    part.arrays = {cell_array("c", {first})};
    return part;
  };
  const auto vertices = [](const std::string& block) {
    MeshPart part;
    part.block = block;
    part.positions = places({0, 0, 0, 1, 0, 0, 2, 0, 0});
    part.cells.types = {CellType::kVertex, CellType::kVertex, CellType::kVertex};
    part.cells.offsets = {0, 1, 2, 3};
    part.cells.connectivity = {0, 1, 2};
    return part;
  };
  const MeshPart a = tetrahedron("a", 0), b = tetrahedron("b", 5);
  const Dataset one = mesh_of_parts(named(), {vertices("nodes"), a}, {});
  EXPECT_EQ(one.kind, DatasetKind::kMesh);
  EXPECT_EQ(one.block, "a");
  // Those that share their arrays are read together.
  const Dataset two = mesh_of_parts(named(), {a, vertices("nodes"), b}, {});
  EXPECT_EQ(two.block, "");
  EXPECT_EQ(two.cells.count(), 2);
  EXPECT_EQ(two.notes.back(),
            "a.vtu: its 3 blocks share no array: 'a', 'b' are read, as they have most to show; "
            "choose with --block");
  // Arrays count for more than cells of a volume, and without any arrays all of the volume is read.
  MeshPart bare = a, bare_too = b, tagged = vertices("nodes");
  bare.arrays.clear();
  bare_too.arrays.clear();
  tagged.arrays = {cell_array("t", {1, 2, 3})};
  EXPECT_EQ(mesh_of_parts(named(), {bare, tagged}, {}).block, "nodes");
  EXPECT_EQ(mesh_of_parts(named(), {bare, vertices("nodes"), bare_too}, {}).cells.count(), 2);
  EXPECT_EQ(mesh_of_parts(named(), {bare, bare_too}, {}).cells.count(), 2);
}

TEST(MeshParts, VerticesAndSurfacesAreParticles) {
  MeshPart points = lines_from(0);
  points.cells.types = {CellType::kVertex, CellType::kVertex, CellType::kVertex};
  points.cells.offsets = {0, 1, 2, 3};
  points.cells.connectivity = {0, 1, 2};
  points.arrays[1] = cell_array("c", {5, 6, 7});
  const Dataset particles = mesh_of_parts(named(), {points}, {});
  EXPECT_EQ(particles.kind, DatasetKind::kParticles);
  EXPECT_EQ(particles.cells.count(), 0);
  ASSERT_EQ(particles.arrays.size(), 2U);  // each vertex is one point
  EXPECT_FALSE(particles.arrays[1].is_cell_data);

  MeshPart surface = lines_from(0);
  surface.is_surface = true;
  const Dataset nodes = mesh_of_parts(named(), {surface}, {});
  EXPECT_EQ(nodes.kind, DatasetKind::kParticles);
  ASSERT_EQ(nodes.arrays.size(), 1U);
  ASSERT_EQ(nodes.notes.size(), 2U);
  EXPECT_EQ(nodes.notes[0],
            "a.vtu: its 2 lines and polygons enclose no volume and are left out: its points are "
            "read");
}

}  // namespace mesh_parts_test
}  // namespace ovoid::io
