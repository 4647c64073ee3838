// SPDX-License-Identifier: Apache-2.0
// One level of LatticeLevels as a lattice file holds it: docs/formats.md, "Levels".
#pragma once

#include "io/hdf5/short_numbers.h"
#include "ovoid/lattice_levels.h"

namespace ovoid::io {

// Gaps are nodes without a kernel between one kernel and the next.
struct StoredLevel {
  explicit StoredLevel(const LatticeLevel& level);

  ShortNumbers gaps, weights;
};

}  // namespace ovoid::io
