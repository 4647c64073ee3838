// SPDX-License-Identifier: Apache-2.0
// Fails if the written columns are not the mesh's, or if a mesh that contradicts itself is written.
#include "io/vtk/vtu_write.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <span>

#include "io/core/test_folder.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid::io {
namespace vtu_write_test {

template <class T>
Bytes owned_bytes(std::vector<T> numbers) {
  auto owner = std::make_shared<std::vector<T>>(std::move(numbers));
  return {owner, std::as_bytes(std::span(*owner))};
}

DataArray array_of(const char* name, std::vector<float> numbers, int components = 1) {
  DataArray array;
  array.name = name;
  array.num_components = components;
  array.num_tuples = static_cast<std::int64_t>(numbers.size()) / components;
  array.bytes = owned_bytes(std::move(numbers));
  return array;
}

// Two tetrahedra that share a face.
Dataset two_cells() {
  Dataset mesh;
  mesh.kind = DatasetKind::kMesh;
  mesh.positions = array_of("", {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1}, 3);
  mesh.cells.types = {CellType::kTetrahedron, CellType::kTetrahedron};
  mesh.cells.offsets = {0, 4, 8};
  mesh.cells.connectivity = {0, 1, 2, 3, 1, 2, 3, 4};
  mesh.arrays = {array_of("a<\"b\"", {1, 2, 3, 4, 5}), array_of("cells", {7, 8})};
  mesh.arrays[1].is_cell_data = true;
  return mesh;
}

class VtuWrite : public testing::Test {
 protected:
  std::string written(const Dataset& mesh) {
    write_dataset(mesh, folder_.file("m.vtu"));
    std::ifstream file(folder_.file("m.vtu"), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  TestFolder folder_;
};

// The appended numbers of the array that the header calls `name`.
template <class T>
std::vector<T> numbers_of(const std::string& text, const std::string& name) {
  const std::size_t at = text.find("Name=\"" + name + "\"");
  if (at == std::string::npos) return {};
  const std::size_t offset = std::stoul(text.substr(text.find("offset=\"", at) + 8));
  const std::size_t begin = text.find('_', text.find("<AppendedData")) + 1 + offset;
  std::uint64_t size = 0;
  std::memcpy(&size, text.data() + begin, sizeof(size));
  std::vector<T> numbers(size / sizeof(T));
  std::memcpy(numbers.data(), text.data() + begin + sizeof(size), size);
  return numbers;
}

TEST_F(VtuWrite, HoldsNodesCellsAndArrays) {
  Dataset mesh = two_cells();
  mesh.arrays[1].unit = "J & kg";
  const std::string text = written(mesh);
  EXPECT_NE(text.find("location=\"vtkDataArray\">J &amp; kg</InformationKey>"), std::string::npos);
  EXPECT_NE(text.find("NumberOfPoints=\"5\" NumberOfCells=\"2\""), std::string::npos);
  EXPECT_EQ(numbers_of<std::int64_t>(text, "connectivity"),
            (std::vector<std::int64_t>{0, 1, 2, 3, 1, 2, 3, 4}));
  EXPECT_EQ(numbers_of<std::int64_t>(text, "offsets"), (std::vector<std::int64_t>{4, 8}));
  EXPECT_EQ(numbers_of<std::uint8_t>(text, "types"), (std::vector<std::uint8_t>{10, 10}));
  EXPECT_EQ(numbers_of<float>(text, "Points").at(14), 1);
  EXPECT_EQ(numbers_of<float>(text, "a&lt;&quot;b&quot;"), (std::vector<float>{1, 2, 3, 4, 5}));
  EXPECT_EQ(numbers_of<float>(text, "cells"), (std::vector<float>{7, 8}));
  EXPECT_LT(text.find("a&lt;"), text.find("</PointData>"));
  EXPECT_GT(text.find("Name=\"cells\""), text.find("<CellData>"));
}

TEST_F(VtuWrite, StructuredCellsBecomeHexahedra) {
  Dataset mesh;
  mesh.kind = DatasetKind::kMesh;
  std::vector<float> places;
  for (int node = 0; node < 12; ++node)
    for (const int index : {node % 3, node / 3 % 2, node / 6})
      places.push_back(static_cast<float>(index));
  mesh.positions = array_of("", places, 3);
  mesh.cells.dims = {3, 2, 2};
  const std::string text = written(mesh);
  EXPECT_EQ(numbers_of<std::uint8_t>(text, "types"), (std::vector<std::uint8_t>{12, 12}));
  EXPECT_EQ(numbers_of<std::int64_t>(text, "connectivity"),
            (std::vector<std::int64_t>{0, 1, 4, 3, 6, 7, 10, 9, 1, 2, 5, 4, 7, 8, 11, 10}));
}

TEST_F(VtuWrite, CellsWithoutTheirTypesNodesBecomePointSets) {
  Dataset mesh = two_cells();
  mesh.cells.types = {CellType::kPyramid, CellType::kOther};
  EXPECT_EQ(numbers_of<std::uint8_t>(written(mesh), "types"), (std::vector<std::uint8_t>{41, 41}));
}

TEST_F(VtuWrite, RefusesWhatContradictsItself) {
  const auto refused = [&](const Dataset& mesh, const std::string& expected) {
    try {
      write_dataset(mesh, folder_.file("x.vtu"));
      ADD_FAILURE() << "written: " << expected;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(expected), std::string::npos) << error.what();
    }
  };
  Dataset mesh = two_cells();
  mesh.cells.connectivity = {0, 1, 2, 3, 1, 2, 5, 4};
  refused(mesh, "cell 1: node 5, must be under 5");
  mesh = two_cells();
  mesh.cells.offsets = {0, 4, 9};
  refused(mesh, "cell 1: nodes 4 to 9");
  mesh = two_cells();
  mesh.cells.offsets = {0, 4};
  refused(mesh, "2 offsets");
  mesh = two_cells();
  mesh.arrays[1].is_cell_data = false;
  refused(mesh, "array 'cells': has 2 tuples");
  mesh = two_cells();
  mesh.positions.num_tuples = 0;
  refused(mesh, "positions");
  mesh = two_cells();
  mesh.cells = {};
  mesh.cells.dims = {2, 2, 2};
  refused(mesh, "2 x 2 x 2 nodes, the mesh has 5");
  Dataset particles = two_cells();
  particles.kind = DatasetKind::kParticles;
  refused(particles, "holds a mesh");
}

}  // namespace vtu_write_test
}  // namespace ovoid::io
