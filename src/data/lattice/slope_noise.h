// SPDX-License-Identifier: Apache-2.0
// Noise in a lattice's samples, by their slopes: where the slope over two samples differs from the
// one over six, noise made it.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "data/lattice/rise_samples.h"

namespace ovoid::data {

// Those of take_rises() whose slope is not 0, by rising slope.
std::vector<RiseSample> those_that_rise(std::span<const RiseSample> samples);

// Mean of agreements; not of none.
double mean_agreement(std::span<const RiseSample> samples);

// Whether slopes tell noise at all: enough samples rise, and they are no waves of a few samples'
// length, whose two slopes run against each other without any noise.
bool can_tell_noise(std::span<const RiseSample> by_rise);

// The median slope, in values over the smallest spacing, where the two slopes disagree; 0 if they
// do so at less than a twentieth of all `num_samples`, or noise cannot be told.
double slope_of_noise(std::span<const RiseSample> by_rise, std::size_t num_samples);

// Whether slopes of take_rises() tell noise. Cost and errors as of that.
bool has_noise(const BrickSource& source);

}  // namespace ovoid::data
