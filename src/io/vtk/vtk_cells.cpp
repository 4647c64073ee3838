// SPDX-License-Identifier: Apache-2.0
#include "io/vtk/vtk_cells.h"

#include <algorithm>
#include <iterator>

namespace ovoid::io {
namespace {

// Of several numbers of a type the first is the one that is written.
constexpr VtkCell kCells[] = {{1, CellType::kVertex, 1},
                              {2, CellType::kVertex, 0},
                              {3, CellType::kLine, 2},
                              {4, CellType::kPolyLine, 0},
                              {5, CellType::kTriangle, 3},
                              {9, CellType::kQuad, 4},
                              {8, CellType::kQuad, 4},
                              {10, CellType::kTetrahedron, 4},
                              {11, CellType::kVoxel, 8},
                              {12, CellType::kHexahedron, 8},
                              {13, CellType::kWedge, 6},
                              {14, CellType::kPyramid, 5},
                              {24, CellType::kQuadraticTetrahedron, 10},
                              {25, CellType::kQuadraticHexahedron, 20},
                              {26, CellType::kQuadraticWedge, 15},
                              {27, CellType::kQuadraticPyramid, 13},
                              {29, CellType::kTriQuadraticHexahedron, 27}};

template <class Condition>
VtkCell first_that(const Condition& condition) {
  const auto* const found = std::find_if(std::begin(kCells), std::end(kCells), condition);
  return found == std::end(kCells) ? VtkCell{} : *found;
}

}  // namespace

CellType cell_type_of_vtk(std::int64_t number) {
  return first_that([&](const VtkCell& cell) { return cell.number == number; }).type;
}

VtkCell vtk_cell(CellType type) {
  return first_that([&](const VtkCell& cell) { return cell.type == type; });
}

}  // namespace ovoid::io
