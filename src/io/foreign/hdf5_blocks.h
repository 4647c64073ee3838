// SPDX-License-Identifier: Apache-2.0
// Adaptive grids whose cells stand in blocks of one shape, all blocks in one dataset.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "io/foreign/hdf5_file.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

struct Hdf5Block {
  std::int64_t row = 0;                      // among the blocks of the datasets
  std::array<std::vector<double>, 3> faces;  // between cells along x, y, z, rising
};

// A variable: [blocks, z, y, x], or with an axis of variables in front, of which it is `variable`.
struct Hdf5BlockArray {
  const Hdf5Dataset* dataset = nullptr;
  std::string name;
  std::int64_t variable = -1;
};

// The cells of the blocks as boxes in `dataset`, which has source, format and notes.
// Throws Error: kFileFormat for blocks without cells or that do not fit
// the datasets, kUnsupported for more than 2^32 - 1 cells, kInvalidArgument if options.array names
// none of the arrays, kOutOfMemory.
Dataset boxes_of_blocks(const Hdf5File& file, const std::vector<Hdf5Block>& blocks,
                        const std::vector<Hdf5BlockArray>& arrays, const ReadOptions& options,
                        Dataset dataset);

}  // namespace ovoid::io
