// SPDX-License-Identifier: Apache-2.0
// How much a look changes between two values. This decides in how many steps the piece between two
// sheets is classified (docs/numerics.md, "Classification", refined).
#pragma once

#include <vector>

#include "view/look/look_table.h"

namespace ovoid::view {

inline constexpr int kMostSteps = 16;            // of a piece; a power of two
inline constexpr float kStepsPerVariation = 10;  // steps for a change of the opacity by 1
inline constexpr double kColorVariation = 0.3;   // what a colour's component counts, an opacity's 1

// [kPaddedEntries]: the running sum over a look's table of the changes of opacity and colour. Read
// by the table's rule, it is the same at two values only if the look is the same between them.
// `path_in_units`: the distance of two sheets, in unit distances of the look.
std::vector<float> look_variation(const LookTable& table, double path_in_units);

// The least of 1, 2, 4, 8 and 16 that is at least `need`, or 16.
constexpr int steps_for(double need) noexcept {
  int steps = 1;
  while (steps < need && steps < kMostSteps) steps *= 2;
  return steps;
}

}  // namespace ovoid::view
