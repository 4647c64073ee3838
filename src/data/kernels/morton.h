// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "ovoid/math.h"

namespace ovoid::data {

inline constexpr int kMortonBits = 21;  // per axis

// Spreads the low 21 bits of x to every third bit.
inline std::uint64_t spread_bits(std::uint64_t x) noexcept {
  x &= 0x1FFFFF;
  x = (x | x << 32) & 0x1F00000000FFFF;
  x = (x | x << 16) & 0x1F0000FF0000FF;
  x = (x | x << 8) & 0x100F00F00F00F00F;
  x = (x | x << 4) & 0x10C30C30C30C30C3;
  x = (x | x << 2) & 0x1249249249249249;
  return x;
}

// Place on a Morton curve of coordinates in [0, 2^21).
inline std::uint64_t morton_key(const Vec3& at) noexcept {
  return spread_bits(static_cast<std::uint64_t>(at[0])) |
         spread_bits(static_cast<std::uint64_t>(at[1])) << 1 |
         spread_bits(static_cast<std::uint64_t>(at[2])) << 2;
}

}  // namespace ovoid::data
