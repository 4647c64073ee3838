// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "ovoid/transfer_function.h"

namespace ovoid::view {

// The colour difference CIEDE2000 [Sharma 2005] of two colours in L*a*b*, all weights 1.
double ciede2000(const Rgb& lab_a, const Rgb& lab_b);

struct PathColor {
  double s = 0;  // fraction of the whole difference, 0 at the first colour and 1 at the last
  Rgb rgb{0, 0, 0};
};

// The shortest chain of colours from `a` to `b` (sRGB) as follow_ciede2000() describes it; both
// ends are there, rounded to the grid. A single colour if they round to the same. The first call
// makes the grid's table of differences (64 thousand, about 20 ms); thread-safe.
std::vector<PathColor> ciede2000_path(const Rgb& a, const Rgb& b);

}  // namespace ovoid::view
