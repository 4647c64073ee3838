// SPDX-License-Identifier: Apache-2.0
#include "io/meshes/plot3d.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "io/core/test_data.h"
#include "io/core/test_folder.h"
#include "io/images/test_volumes.h"

namespace ovoid::io {
namespace plot3d_test {

// A grid of 3 x 2 x 2 nodes at (i, j, k) and a flow on it, in any layout.
struct Files {
  bool is_big_endian = false;
  bool has_marks = false;
  bool is_multiple = false;
  bool is_double = false;
  std::vector<std::int32_t> iblank;  // empty: none
  int num_grids = 1;

  std::string grid() const {
    std::string data;
    for (int g = 0; g < num_grids; ++g) {
      std::string numbers;
      for (int axis = 0; axis < 3; ++axis) {
        for (int n = 0; n < 12; ++n)
          numbers += real(axis == 0 ? n % 3 + 2 * g : axis == 1 ? n / 3 % 2 : n / 6);
      }
      for (const std::int32_t value : iblank) numbers += ordered(value);
      data += record(numbers);
    }
    return header() + data;
  }

  std::string solution() const {
    std::string data;
    for (int g = 0; g < num_grids; ++g) {
      data += record(real(0.5) + real(1) + real(1000) + real(7.5));
      std::string numbers;
      for (int n = 0; n < 60; ++n) numbers += real(n < 12 ? n + 1 : n / 12 == 1 ? 2 * (n - 11) : n);
      data += record(numbers);
    }
    return header() + data;
  }

 private:
  std::string header() const {
    std::string dims;
    for (int g = 0; g < num_grids; ++g) {
      for (const int n : {3, 2, 2}) dims += ordered(n);
    }
    return (is_multiple ? record(ordered(num_grids)) : "") + record(dims);
  }
  template <typename T>
  std::string ordered(T value) const {
    std::string bytes = bytes_of(std::vector<T>{value});
    if (is_big_endian) std::reverse(bytes.begin(), bytes.end());
    return bytes;
  }
  std::string real(double value) const {
    return is_double ? ordered(value) : ordered(static_cast<float>(value));
  }
  std::string record(const std::string& bytes) const {
    const std::string mark = has_marks ? ordered(static_cast<std::int32_t>(bytes.size())) : "";
    return mark + bytes + mark;
  }
};

Dataset read(const TestFolder& folder, const Files& files) {
  return read_dataset({folder.write("g.xyz", files.grid()), folder.write("a.q", files.solution())});
}

double value(const DataArray& array, std::size_t i) {
  return array.type == ScalarType::kFloat64 ? values_of<double>(array)[i]
                                            : values_of<float>(array)[i];
}

TEST(Plot3d, EveryLayoutGivesTheSameMesh) {
  const TestFolder folder;
  for (unsigned i = 0; i < 16; ++i) {
    Files files;
    files.is_big_endian = (i & 1U) != 0;
    files.has_marks = (i & 2U) != 0;
    files.is_multiple = (i & 4U) != 0;
    files.is_double = (i & 8U) != 0;
    const Dataset mesh = read(folder, files);
    EXPECT_EQ(mesh.format, "PLOT3D");
    EXPECT_EQ(mesh.kind, DatasetKind::kMesh);
    EXPECT_EQ(mesh.cells.dims, (Index3{3, 2, 2}));
    EXPECT_EQ(mesh.positions.type, files.is_double ? ScalarType::kFloat64 : ScalarType::kFloat32);
    EXPECT_EQ(value(mesh.positions, 3 * 11), 2) << i;  // the last node is (2, 1, 1)
    EXPECT_EQ(value(mesh.positions, 3 * 11 + 1), 1);
    EXPECT_EQ(value(mesh.positions, 3 * 11 + 2), 1);
    EXPECT_EQ(mesh.times, std::vector<double>{7.5});
    EXPECT_EQ(mesh.array().name, "Density");
    EXPECT_EQ(value(mesh.array(), 4), 5);
    // Node 4: rho 5, momentum (10, 28, 40), energy 52.
    const DataArray& momentum = mesh.array("Momentum");
    EXPECT_EQ(value(momentum, 3 * 4), 10);
    EXPECT_EQ(value(momentum, 3 * 4 + 1), 28);
    EXPECT_EQ(value(momentum, 3 * 4 + 2), 40);
    EXPECT_EQ(value(mesh.array("StagnationEnergy"), 4), 52);
    const double squares = 10 * 10 + 28 * 28 + 40 * 40;
    EXPECT_NEAR(value(mesh.array("VelocityMagnitude"), 4), std::sqrt(squares) / 5, 1e-5);
    EXPECT_NEAR(value(mesh.array("Pressure"), 4), 0.4 * (52 - 0.5 * squares / 5), 1e-4);
  }
}

TEST(Plot3d, BlankedNodesTakeTheirCellsAway) {
  const TestFolder folder;
  Files files;
  files.iblank = {0, 1, 1, 1, 1, -2, 1, 1, 1, 1, 1, 1};  // negative: where grids overlap
  const Dataset mesh = read(folder, files);
  EXPECT_FALSE(mesh.cells.is_structured());
  EXPECT_EQ(mesh.cells.types, std::vector{CellType::kHexahedron});
  EXPECT_EQ(mesh.cells.connectivity[0], 1U);
  EXPECT_EQ(mesh.num_positions(), 12);
  files.iblank.assign(12, 0);
  EXPECT_NE(error_of([&] { read(folder, files); }).find("all 2 cells or points are hidden"),
            std::string::npos);
}

TEST(Plot3d, SeveralGridsAreBlocks) {
  const TestFolder folder;
  Files files;
  files.is_multiple = true;
  files.num_grids = 2;
  const Dataset mesh = read(folder, files);
  ASSERT_EQ(mesh.blocks.size(), 2U);
  EXPECT_EQ(mesh.blocks[1].name, "2");
  EXPECT_EQ(mesh.num_positions(), 24 - 4);  // they touch
  EXPECT_EQ(mesh.cells.count(), 4);
}

TEST(Plot3d, SolutionsAreSteps) {
  const TestFolder folder;
  const Files files;
  const std::string grid = folder.write("g.xyz", files.grid());
  const std::string flow = folder.write("a.q", files.solution());
  ReadOptions options;
  options.step = 1;
  const Dataset mesh = read_dataset({grid, flow, flow}, options);
  EXPECT_EQ(mesh.num_steps, 2);
  EXPECT_EQ(mesh.step, 1);
  EXPECT_EQ(read_dataset({flow, grid}).num_steps, 1);  // either order
}

TEST(Plot3d, WhatDoesNotFitIsNamed) {
  const TestFolder folder;
  const Files files;
  const std::string grid = folder.write("g.xyz", files.grid());
  const std::string flow = folder.write("a.q", files.solution());
  EXPECT_NE(error_of([&] { read_dataset({grid}); }).find("is a PLOT3D grid, which has no arrays"),
            std::string::npos);
  EXPECT_NE(error_of([&] { read_dataset({flow}); }).find("is a PLOT3D solution, which has no p"),
            std::string::npos);
  EXPECT_NE(error_of([&] {
              read_dataset({grid, grid});
            }).find("g.xyz: is a PLOT3D grid: expected"),
            std::string::npos);
  Files other;
  other.is_multiple = true;
  other.num_grids = 2;
  EXPECT_NE(error_of([&] {
              read_dataset({grid, folder.write("b.q", other.solution())});
            }).find("b.q: is a PLOT3D solution of 3x2x2, 3x2x2 nodes: the grid"),
            std::string::npos);
  // One byte less, one more that is not zero, or a wrong record mark.
  const auto has_layout = [&](const std::string& bytes) {
    return find_plot3d(*open_memory("g", std::as_bytes(std::span(bytes))), Plot3dContent::kGrid)
        .has_value();
  };
  EXPECT_TRUE(has_layout(files.grid()));
  EXPECT_TRUE(has_layout(files.grid() + std::string(500, '\0')));
  EXPECT_FALSE(has_layout(files.grid() + "x"));
  EXPECT_FALSE(has_layout(files.grid().substr(1)));
  std::string cut = files.grid();
  cut.pop_back();
  EXPECT_FALSE(has_layout(cut));
  Files marked;
  marked.has_marks = true;
  std::string wrong = marked.grid();
  wrong[0] ^= 1;
  EXPECT_FALSE(has_layout(wrong));
}

TEST(Plot3d, TheBluntFinIsAsItsReadmeSays) {
  const std::string grid = real_data_path("bluntfin/bluntfinxyz.bin");
  if (grid.empty()) GTEST_SKIP() << "no real data beside the project (OVOID_DATA)";
  const Dataset mesh = read_dataset({grid, real_data_path("bluntfin/bluntfinq.bin")});
  EXPECT_EQ(mesh.cells.dims, (Index3{40, 32, 32}));
  const auto positions = values_of<float>(mesh.positions);
  EXPECT_NEAR(*std::min_element(positions.begin(), positions.end()), -7.816, 1e-3);
  EXPECT_NEAR(*std::max_element(positions.begin(), positions.end()), 14.362, 1e-3);
  const auto density = values_of<float>(mesh.array());
  EXPECT_NEAR(*std::min_element(density.begin(), density.end()), 0.1926, 1e-6);
  EXPECT_NEAR(*std::max_element(density.begin(), density.end()), 4.9775, 1e-6);
}

}  // namespace plot3d_test
}  // namespace ovoid::io
