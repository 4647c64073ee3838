// SPDX-License-Identifier: Apache-2.0
// LatticeLevels as a lattice file holds them, level by level: docs/formats.md, "Levels".
#pragma once

#include "io/hdf5/short_numbers.h"
#include "ovoid/lattice_levels.h"

namespace ovoid::io {

// Gaps are nodes without a kernel between one kernel and the next.
struct StoredLevel {
  explicit StoredLevel(const LatticeLevel& level);

  ShortNumbers gaps, weights;
};

ShortNumbers stored_holes(const LatticeLevels& levels);

}  // namespace ovoid::io
