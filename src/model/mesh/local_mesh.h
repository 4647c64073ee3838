// SPDX-License-Identifier: Apache-2.0
// What a process works on of a mesh or of boxes: all of it, or, in a team, its part of space.
#pragma once

#include <cstdint>
#include <vector>

#include "model/mesh/boxes.h"
#include "model/mesh/mesh_cells.h"

namespace ovoid::model {

// Nodes and cells with values, a column for each chosen array. In a team each node and each cell is
// the own of one process; all cells around its own nodes are there, with all of their nodes, the
// others' own beside.
struct LocalMesh {
  MeshNodes nodes;
  MeshCells cells;
  SiteValues values;  // per node, or per cell
  bool is_cell_data = false;
  // Empty: all are.
  std::vector<bool> is_own_node, is_own_cell;
  // In a team: which nodes of the whole they are (DatasetShare::nodes); of several at one place all
  // say the first.
  std::vector<std::uint64_t> numbers;

  bool owns_node(std::uint32_t node) const { return is_own_node.empty() || is_own_node[node]; }
  bool owns_cell(std::size_t cell) const { return is_own_cell.empty() || is_own_cell[cell]; }
};

// The run's dataset. All of a team call it. Throws Error as load_nodes(), load_cells() and
// load_values() do.
LocalMesh load_local_mesh(const ModelRun& run, const ChosenArrays& chosen);

// That of a team's process, whose dataset is a share of the mesh (DatasetShare). Each node and cell
// is sent to those that have one of the cell's nodes.
LocalMesh team_mesh(const ModelRun& run, const ChosenArrays& chosen);

// Boxes with values, the own of one process each.
struct LocalBoxes {
  Boxes boxes;
  SiteValues values;
};

// As load_local_mesh().
LocalBoxes load_local_boxes(const ModelRun& run, const ChosenArrays& chosen);

// One's own boxes, and behind them those of a team's others that may touch one of them. All call
// it.
Boxes with_neighbors(const ModelRun& run, const Boxes& own);

}  // namespace ovoid::model
