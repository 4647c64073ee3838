// SPDX-License-Identifier: Apache-2.0
// Which columns of a table are the places of its points (lay_out_points() tells the rules).
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "io/points/point_columns.h"

namespace ovoid::io {

struct PositionColumns {
  std::array<std::optional<std::size_t>, 3> columns;  // x, y, z; the last may be none
  bool is_depth = false;                              // the last counts downwards
  std::string unit;                                   // of all of them; empty if they differ
};

// Notes what was taken unless it says so by itself. Throws Error(kFileFormat) naming `where`.
PositionColumns find_position_columns(const std::string& where,
                                      const std::vector<PointColumn>& columns,
                                      std::vector<std::string>& notes);

}  // namespace ovoid::io
