// SPDX-License-Identifier: Apache-2.0
// One level of LatticeLevels as a lattice file holds it: docs/formats.md, "Levels".
#pragma once

#include <cstddef>
#include <vector>

#include "ovoid/lattice_levels.h"

namespace ovoid::io {

// Gaps are nodes without a kernel between one kernel and the next. In the shortest type that holds
// all, native byte order.
struct StoredLevel {
  explicit StoredLevel(const LatticeLevel& level);

  ScalarType gap_type = ScalarType::kUInt8, weight_type = ScalarType::kInt8;
  std::vector<std::byte> gaps, weights;
};

}  // namespace ovoid::io
