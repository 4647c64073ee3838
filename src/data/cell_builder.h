// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "ovoid/dataset.h"

namespace ovoid::data {

// Makes the cells of a mesh, one after the other.
struct CellBuilder {
  std::vector<CellType> types;
  std::vector<std::int64_t> offsets{0};
  std::vector<std::uint32_t> connectivity;

  // Ends the cell of the nodes that were added to `connectivity` since the last.
  void end_cell(CellType type) {
    types.push_back(type);
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
  }

  template <typename Nodes>
  void add(CellType type, const Nodes& nodes) {
    connectivity.insert(connectivity.end(), nodes.begin(), nodes.end());
    end_cell(type);
  }

  Cells finish() && {
    Cells cells;
    cells.types = std::move(types);
    cells.offsets = std::move(offsets);
    cells.connectivity = std::move(connectivity);
    return cells;
  }
};

}  // namespace ovoid::data
