// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "simd/simd_target.h"

namespace ovoid::simd {

// Single-precision multiply-adds per second that one thread of this machine can do with the target
// while nothing else is in its way: measured in two milliseconds, on registers alone. The bound
// that times of stages are held against.
double multiply_add_peak(const SimdTarget& target);

// Bytes per second that one thread reads in order from memory: of 4 MiB that caches were told to
// forget (where the machine can be told), measured in some milliseconds. 0 if there are none.
double bandwidth_peak(const SimdTarget& target);

}  // namespace ovoid::simd
