// SPDX-License-Identifier: Apache-2.0
// Kinds of cells by VTK's numbers.
#pragma once

#include <cstdint>

#include "ovoid/dataset.h"

namespace ovoid::io {

struct VtkCell {
  std::uint8_t number = 41;  // of what is none of the others: a convex set of points
  CellType type = CellType::kOther;
  int num_nodes = 0;  // of each; 0: any
};

// The type that VTK has under a number. Pixels are quads whose last two corners are exchanged, sets
// of vertices vertices of several nodes.
CellType cell_type_of_vtk(std::int64_t number);

// What VTK has for a type.
VtkCell vtk_cell(CellType type);

}  // namespace ovoid::io
