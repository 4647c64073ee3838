// SPDX-License-Identifier: Apache-2.0
#include "io/check_dataset.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <memory>
#include <string>

#include "io/images/test_volumes.h"

namespace ovoid::io {
namespace check_dataset_test {

Dataset lattice() {
  Dataset dataset;
  dataset.lattice.dims = {3, 2, 1};
  dataset.arrays = {make_array<float>("v", ScalarType::kFloat32, counting<float>(6))};
  return dataset;
}

Dataset boxes() {
  Dataset dataset;
  dataset.kind = DatasetKind::kBoxes;
  dataset.positions = make_array<float>("positions", ScalarType::kFloat32, counting<float>(6), 3);
  dataset.box_sizes = make_array<double>("sizes", ScalarType::kFloat64, counting<double>(6), 3);
  dataset.arrays = {make_array<float>("v", ScalarType::kFloat32, {1, 2})};
  return dataset;
}

Dataset mesh() {
  Dataset dataset = boxes();
  dataset.kind = DatasetKind::kMesh;
  dataset.cells.types = {CellType::kLine};
  dataset.cells.offsets = {0, 2};
  dataset.cells.connectivity = {0, 1};
  dataset.arrays.push_back(make_array<float>("c", ScalarType::kFloat32, {3}));
  dataset.arrays.back().is_cell_data = true;
  return dataset;
}

// What is said of the dataset after a change; "" if nothing.
template <typename Change>
std::string after(Dataset dataset, const Change& change) {
  change(dataset);
  return error_of([&] { check_dataset(dataset); });
}

const std::string kWrong = "file-format: ";

TEST(CheckDataset, WhatFitsPasses) {
  for (const Dataset& dataset : {lattice(), boxes(), mesh()})
    EXPECT_EQ(after(dataset, [](Dataset&) {}), "");
}

TEST(CheckDataset, StepsAndTimes) {
  EXPECT_EQ(after(lattice(), [](Dataset& d) { d.num_steps = 0; }),
            kWrong + "a step that is not there");
  EXPECT_EQ(after(lattice(), [](Dataset& d) { d.step = 1; }), kWrong + "a step that is not there");
  EXPECT_EQ(after(lattice(), [](Dataset& d) { d.step = -1; }), kWrong + "a step that is not there");
  EXPECT_EQ(after(lattice(),
                  [](Dataset& d) {
                    d.num_steps = 3;
                    d.times = {1, 2};
                  }),
            kWrong + "2 times for 3 steps");
  const auto halves = [](Dataset& d) {
    d.num_steps = 3;
    d.series = SeriesKind::kStaggered;
  };
  EXPECT_EQ(after(lattice(), halves), "") << "times may be missing";
  EXPECT_EQ(after(lattice(),
                  [&](Dataset& d) {
                    halves(d);
                    d.times = {1, 2, 5};
                  }),
            kWrong + "times at uneven distances, of steps that are halves of one lattice in turn");
}

TEST(CheckDataset, Lattices) {
  EXPECT_NE(after(lattice(), [](Dataset& d) { d.lattice.dims[2] = 0; }), "");
  EXPECT_NE(after(lattice(), [](Dataset& d) { d.lattice.dims[2] = std::int64_t{1} << 40; }), "");
  EXPECT_NE(after(lattice(), [](Dataset& d) { d.lattice.world_from_index.linear().setZero(); }),
            "");
  EXPECT_EQ(after(lattice(), [](Dataset& d) { d.arrays.clear(); }),
            kWrong + "a lattice without an array");
  EXPECT_EQ(after(lattice(), [](Dataset& d) { d.lattice.dims[2] = 2; }),
            kWrong + "6 tuples for 12 samples");
}

TEST(CheckDataset, ArraysHoldWhatTheySay) {
  EXPECT_EQ(after(lattice(), [](Dataset& d) { d.arrays[0].bytes = {}; }),
            kWrong + "array 'v' of another size than its own");
  EXPECT_EQ(after(lattice(), [](Dataset& d) { d.arrays[0].num_components = 0; }),
            kWrong + "array 'v' of another size than its own");
  EXPECT_EQ(after(lattice(), [](Dataset& d) { d.arrays[0].type = ScalarType::kFloat64; }),
            kWrong + "array 'v' of another size than its own");
  EXPECT_EQ(after(lattice(), [](Dataset& d) { d.arrays[0].value_scale = 0; }),
            kWrong + "array 'v' whose numbers stand for s x 0 + 0");
  EXPECT_NE(after(lattice(),
                  [](Dataset& d) {
                    d.arrays[0].value_offset = std::numeric_limits<double>::quiet_NaN();
                  }),
            "");
}

TEST(CheckDataset, PointsBoxesAndCells) {
  EXPECT_EQ(after(boxes(), [](Dataset& d) { d.arrays[0].num_tuples = 3; }),
            kWrong + "3 tuples for 2 places");
  EXPECT_EQ(after(boxes(), [](Dataset& d) { d.positions.num_components = 2; }),
            kWrong + "positions that are not three floating-point numbers each");
  EXPECT_EQ(after(boxes(), [](Dataset& d) { d.box_sizes = {}; }),
            kWrong + "sizes of boxes that are not three floating-point numbers each");
  EXPECT_EQ(after(boxes(), [](Dataset& d) { d.box_sizes.num_tuples = 1; }),
            kWrong + "1 tuples for 2 boxes");
  EXPECT_EQ(after(mesh(), [](Dataset& d) { d.arrays[1].num_tuples = 2; }),
            kWrong + "2 tuples for 1 cells");
  EXPECT_EQ(after(mesh(),
                  [](Dataset& d) {
                    d.cells.offsets = {0, 3};
                  }),
            kWrong + "cells whose nodes are not there");
  EXPECT_EQ(after(mesh(),
                  [](Dataset& d) {
                    d.cells = Cells{{}, {}, {}, {2, 2, 1}};
                  }),
            kWrong + "2 nodes of a grid of 2x2x1");
}

}  // namespace check_dataset_test
}  // namespace ovoid::io
