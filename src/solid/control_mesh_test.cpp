// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>

#include "data/cell_builder.h"
#include "model/own_array.h"
#include "ovoid/error.h"
#include "ovoid/solid.h"
#include "solid/test_solids.h"

namespace ovoid::solid {
namespace control_mesh_test {

std::string control_refusal(const Dataset& dataset, const ControlMeshOptions& options = {}) {
  try {
    make_control_mesh(dataset, options);
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

Dataset grid_dataset() {
  Dataset dataset = make_solid_dataset(grid_solid(3, [](const Vec3& p) { return p[0] + p[2]; }));
  dataset.source = "grid.vtu";
  return dataset;
}

// Fails if the order of VTK's hexahedra is taken for the voxels', or places and densities part.
TEST(ControlMesh, GoesToADatasetAndBack) {
  const SolidMesh star = make_sample_control_mesh();
  EXPECT_NO_THROW(check_solid_mesh(star));
  SolidMesh again = make_control_mesh(make_solid_dataset(star));
  EXPECT_EQ(again.cells, star.cells);
  EXPECT_EQ(again.positions, star.positions);
  for (std::size_t v = 0; v < star.num_vertices(); ++v)
    EXPECT_EQ(again.densities[v], static_cast<double>(static_cast<float>(star.densities[v])));
  EXPECT_EQ(again.name, "density");
}

// Fails if the grid of a file is no mesh of its cells, or a node twice is two vertices.
TEST(ControlMesh, TakesGridsVoxelsAndNodesThatStandTwice) {
  const Dataset dataset = grid_dataset();
  const SolidMesh expected = make_control_mesh(dataset);
  Dataset structured = dataset;
  structured.cells = {};
  structured.cells.dims = {3, 3, 3};
  EXPECT_EQ(make_control_mesh(structured).cells, expected.cells);
  Dataset twice = dataset;
  std::vector<double> positions = expected.positions;
  std::vector<float> values(expected.densities.begin(), expected.densities.end());
  for (int axis = 0; axis < 3; ++axis)
    positions.push_back(positions[static_cast<std::size_t>(axis)]);
  values.push_back(values[0]);
  twice.positions = model::array_of_numbers("positions", 3, positions);
  twice.arrays = {model::array_of_numbers("density", 1, values)};
  std::vector<std::uint32_t> connectivity = dataset.cells.connectivity.to_vector();
  connectivity[0] = 27;
  twice.cells.connectivity = connectivity;
  EXPECT_EQ(make_control_mesh(twice).cells, expected.cells);
  Dataset voxels = dataset;
  data::CellBuilder builder;
  for (const auto& cell : expected.cells) builder.add(CellType::kVoxel, cell);
  voxels.cells = std::move(builder).finish();
  EXPECT_EQ(make_control_mesh(voxels).cells, expected.cells);
}

// Fails if faces are told by their vertices alone: two cells share the four corners of a
// tetrahedron, and go around them in different ways.
TEST(ControlMesh, FacesOfDifferentEdgesAreRefused) {
  SolidMesh mesh;
  mesh.positions = {9, -1, 1,  11, -1, -1, 9,  1,  -1, 11, 1, 1,  -1, 9,  1,  -1, 11, -1,
                    1, 9,  -1, 1,  11, 1,  -1, -1, 1,  -1, 1, -1, 1,  -1, -1, 1,  1,  1};
  mesh.densities.assign(12, 1.0);
  mesh.cells = {{11, 10, 8, 9, 7, 6, 4, 5}, {8, 10, 11, 9, 0, 1, 3, 2}};
  try {
    check_solid_mesh(mesh);
    ADD_FAILURE() << "accepted";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "cells[0] and [1]: share four vertices, but not the edges between");
  }
}

// Fails if a message does not name the file and what is wrong in it.
TEST(ControlMesh, RefusesWhatIsNone) {
  const auto expect = [](const char* word, const auto& change,
                         const ControlMeshOptions& options = {}) {
    Dataset dataset = grid_dataset();
    change(dataset);
    const std::string refusal = control_refusal(dataset, options);
    EXPECT_NE(refusal.find("'grid.vtu': "), std::string::npos) << refusal;
    EXPECT_NE(refusal.find(word), std::string::npos) << refusal;
  };
  const auto nothing = [](Dataset&) {};
  expect("is of kind particles", [](Dataset& d) { d.kind = DatasetKind::kParticles; });
  expect("has no array", [](Dataset& d) { d.arrays.clear(); });
  expect("has no cells", [](Dataset& d) { d.cells = {}; });
  expect("nothing", nothing, {.array = "nothing"});
  expect("component", nothing, {.component = 3});
  expect("cells[0]: is a tetrahedron", [](Dataset& d) {
    data::CellBuilder cells;
    cells.add(CellType::kTetrahedron, std::array{0U, 1U, 3U, 9U});
    d.cells = std::move(cells).finish();
  });
  expect("cells[3]: is a curved hexahedron", [](Dataset& d) {
    data::CellBuilder cells;
    const auto from = d.cells.connectivity.view();
    for (std::size_t c = 0; c < 3; ++c) cells.add(CellType::kHexahedron, from.subspan(8 * c, 8));
    std::vector<std::uint32_t> nodes(20);
    cells.add(CellType::kQuadraticHexahedron, nodes);
    d.cells = std::move(cells).finish();
  });
  expect("a value per cell", [](Dataset& d) {
    d.arrays = {model::array_of_numbers("density", 1, std::vector<float>{1, 2, 3, 4, 5, 6, 7, 8})};
    d.arrays[0].is_cell_data = true;
  });
  constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();
  expect("node 5: has no value of 'density'", [](Dataset& d) {
    std::vector<float> values(27, 1.0F);
    values[5] = kMissing;
    values[6] = 2;
    d.arrays = {model::array_of_numbers("density", 1, values)};
  });
  expect("node 4: its position is not finite", [](Dataset& d) {
    std::vector<float> positions;
    for (const double x : grid_solid(3, [](const Vec3&) { return 0; }).positions)
      positions.push_back(static_cast<float>(x));
    positions[12] = kMissing;
    d.positions = model::array_of_numbers("positions", 3, positions);
  });
}

}  // namespace control_mesh_test
}  // namespace ovoid::solid
