// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "labels/label_brick.h"
#include "simd/simd_target.h"

namespace ovoid::labels {

// Samples along each axis of what a brick's scores are made of, and how many of them lie before its
// first cell's first sample.
inline constexpr int kWindowEdge = 28;
inline constexpr int kBeforeBrick = 10;

// The brick of a window of ranks, [kWindowEdge]^3, x fastest.
LabelBrick smoothed_brick(const simd::SimdTarget& target, const std::uint16_t* window);

}  // namespace ovoid::labels
