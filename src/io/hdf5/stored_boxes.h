// SPDX-License-Identifier: Apache-2.0
// The boxes of LatticeBoxes as a lattice file holds them: docs/formats.md, "Boxes".
#pragma once

#include <array>

#include "io/hdf5/short_numbers.h"
#include "ovoid/lattice_boxes.h"

namespace ovoid::io {

// A list for each number that a box has: lists of like numbers pack better.
struct StoredBoxes {
  static constexpr std::array kNames = {"gaps",   "sizes_x", "sizes_y", "sizes_z",
                                        "firsts", "rises_x", "rises_y", "rises_z"};

  explicit StoredBoxes(const LatticeBoxes& boxes);

  std::array<ShortNumbers, kNames.size()> lists;
};

}  // namespace ovoid::io
