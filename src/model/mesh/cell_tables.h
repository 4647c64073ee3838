// SPDX-License-Identifier: Apache-2.0
// What a cell's type says about its nodes: faces, which nodes are neighbours, and in what order
// they surround each.
#pragma once

#include <cstdint>
#include <vector>

#include "ovoid/dataset.h"

namespace ovoid::model {

// Node numbers are local, in VTK's order.
struct CellTable {
  int num_nodes = 0;  // 0: any number (kPolyLine, kOther)
  int dimension = 3;  // 0 to 3
  // Cycles of nodes seen from outside, the middle nodes of curved edges among them. Solids only.
  std::vector<std::vector<std::uint8_t>> faces;
  // Of each node, those joined to it by half an edge or an edge; of middle nodes also the middle
  // nodes of the faces' other edges, without which they would have neighbours on one line only.
  std::vector<std::vector<std::uint8_t>> neighbors;
  // Solids only. Of each node, its neighbours in the order in which they surround it: as rays they
  // span the cell's solid angle there. The first has no opposite among them.
  std::vector<std::vector<std::uint8_t>> fans;

  // All nodes are taken for neighbours, nothing is known of faces.
  bool has_any_nodes() const noexcept { return num_nodes == 0; }
};

const CellTable& table_of(CellType type);

}  // namespace ovoid::model
