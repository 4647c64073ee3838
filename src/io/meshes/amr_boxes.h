// SPDX-License-Identifier: Apache-2.0
// Adaptive grids as boxes: the cells that no finer grid covers.
#pragma once

#include <string>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// One grid of one level: axis-aligned cells, i fastest.
struct AmrGrid {
  std::string source;  // for messages
  int level = 0;       // 0 is the coarsest
  Vec3 origin;         // the lower corner of the first cell
  Vec3 spacing;        // edges of a cell, > 0
  Index3 num_cells{0, 0, 0};
  std::vector<DataArray> arrays;  // a tuple per cell; "vtkGhostType" hides cells
};

// kBoxes: the cells whose centres lie in no grid of a finer level and that are not hidden, with the
// arrays that every grid has. `dataset` has source, format and notes. Throws Error(kFileFormat) if
// nothing, or no array, is left, or an array has not a tuple per cell; kUnsupported for 2^32 cells
// and more.
Dataset boxes_of_grids(Dataset dataset, const std::vector<AmrGrid>& grids,
                       const ReadOptions& options);

}  // namespace ovoid::io
