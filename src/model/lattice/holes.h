// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <stop_token>
#include <vector>

#include "ovoid/lattice.h"

namespace ovoid::model {

// Gives every missing (not finite) sample a value and returns which they were (an empty vector if
// none is). Samples beside existing ones get the mean of those, then those beside them, and so on
// inwards; neighbours share a face. At least one sample must be finite. Cost: proportional to the
// number of samples. Throws Error(kCancelled).
std::vector<bool> fill_missing(std::span<float> samples, const Index3& dims, std::stop_token stop);

// Makes the samples that fill_missing() named missing again: NaN.
void restore_missing(std::span<float> samples, const std::vector<bool>& missing);

}  // namespace ovoid::model
