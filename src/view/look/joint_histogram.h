// SPDX-License-Identifier: Apache-2.0
// How values and slopes of samples go together [Kindlmann 1998]: where many samples of a value rise
// little, there is a material; between two materials lies a boundary, whose samples rise much; and
// where slopes of neighbours disagree, there is noise.
#pragma once

#include <span>
#include <vector>

#include "data/lattice/rise_samples.h"
#include "ovoid/look.h"

namespace ovoid::view {

// Of samples of a lattice (data::take_rises()); of none: nothing found. Cost: some sorting, twenty
// milliseconds.
Materials find_materials(std::span<const data::RiseSample> samples);

// Share, in [0, 1], of what rises that rises the same way: 1 for a ramp from side to side, near 0
// for whatever is closed. 0 where nothing rises.
double one_sidedness(std::span<const data::RiseSample> samples);

}  // namespace ovoid::view
