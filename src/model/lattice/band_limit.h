// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stop_token>
#include <vector>

#include "ovoid/lattice.h"

namespace ovoid::model {

struct BandLimit {
  double radius = 0.5;  // cycles per sample; nothing at or beyond it is left
  int threads = 0;      // 0: one per hardware thread
  std::stop_token stop{};
};

// The share of the radius from which on frequencies are attenuated, as a raised cosine: a band with
// a hard end would ring around edges.
inline constexpr double kBandShoulder = 0.9;

// Takes from the samples (x fastest, finite) what is beyond a ball of frequencies: what a
// body-centred lattice of T = 1 / (2 radius) samples can keep. The volume is mirrored at its faces
// (discrete cosine transform). Throws Error(kCancelled); std::bad_alloc. Cost: six passes of fast
// transforms of lines.
void limit_band(std::vector<float>& samples, const Index3& dims, const BandLimit& limit);

// The same of steps behind each other, [num_steps][z][y][x]: a ball in four dimensions, cycles per
// step taken for cycles per sample.
void limit_band_in_time(std::vector<float>& samples, const Index3& dims, std::int64_t num_steps,
                        const BandLimit& limit);

}  // namespace ovoid::model
