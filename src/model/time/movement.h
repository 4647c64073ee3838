// SPDX-License-Identifier: Apache-2.0
// How positions move from one step of a series to the next.
#pragma once

#include <string>

#include "ovoid/dataset.h"

namespace ovoid::model {

// Empty if two steps, no lattices, are of the same things, which then move straight from the one to
// the other; else why that cannot be known.
std::string difference_of(const Dataset& a, const Dataset& b);

// Positions at a share of the way, float64; through the faces of a periodic box where that is
// shorter. The steps are of the same things.
DataArray moved_positions(const Dataset& from, const Dataset& to, double share);

// The length that 95 % of the ways do not exceed, world units, of up to 65,536 of them.
double usual_way(const Dataset& from, const Dataset& to);

}  // namespace ovoid::model
