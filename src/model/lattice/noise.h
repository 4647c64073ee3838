// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "ovoid/math.h"

namespace ovoid::model {

// Random numbers that are the same on every machine and in every library version: SplitMix64
// (Steele, Lea, Flood 2014).
class Random {
 public:
  explicit Random(std::uint64_t seed) noexcept : state_(seed) {}
  std::uint64_t next() noexcept;
  double uniform(double lo, double hi) noexcept;  // in [lo, hi)

 private:
  std::uint64_t state_;
};

// Smooth noise in [-1, 1] with features about one unit wide: random numbers at whole positions,
// blended in between with continuous first derivative. |coordinates| < 2^31.
double smooth_noise(const Vec3& position, std::uint64_t seed) noexcept;

}  // namespace ovoid::model
