// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "ovoid/field.h"

namespace ovoid::fit {

// The root mean square of the noise over all samples, in values; 0 where there is none that could
// be told, or less than `least`. `samples`: all of `source`, x fastest. By differences that smooth
// fields leave nothing in, if these are as large over twice the distance, as those of independent
// noise are and those of a field are not. Else, if slopes tell noise at all
// (data/lattice/slope_noise.h), by what quadratic functions leave in the quarter of small cubes
// where they leave least. docs/numerics.md, "Levels of a scan". Cost: some thirty milliseconds.
double noise_of_lattice(const BrickSource& source, std::span<const float> samples, double least);

}  // namespace ovoid::fit
