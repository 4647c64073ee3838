// SPDX-License-Identifier: Apache-2.0
// Axis-aligned boxes (adaptive grids), checked, and as the cells of a mesh.
#pragma once

#include <vector>

#include "model/kernel_parts.h"
#include "model/mesh_cells.h"

namespace ovoid::model {

struct Boxes {
  std::vector<double> centers;  // [n, 3], finite or not
  std::vector<double> edges;    // [n, 3], > 0

  std::size_t count() const noexcept { return centers.size() / 3; }
  Vec3 center(std::size_t i) const noexcept { return Vec3(centers.data() + 3 * i); }
  Vec3 edge(std::size_t i) const noexcept { return Vec3(edges.data() + 3 * i); }
};

// Throws Error(kInvalidArgument) that names the box: edges that are not positive.
Boxes load_boxes(const ModelRun& run);

// Hexahedra with corners of their own; those of boxes that touch, at the same places to the bit: on
// a grid of a thousandth of the least edge. Boxes of different sizes that touch share no face.
Mesh mesh_of_boxes(const Boxes& boxes);

}  // namespace ovoid::model
