// SPDX-License-Identifier: Apache-2.0
#include "model/lattice/noise.h"

#include <cmath>

namespace ovoid::model {

namespace {

// The output function of SplitMix64: every bit of the input reaches every bit of the result.
std::uint64_t scramble(std::uint64_t z) noexcept {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
  return z ^ (z >> 31);
}

constexpr std::uint64_t kGolden =
    0x9E3779B97F4A7C15U;  // 2^64 / golden ratio, SplitMix64's increment

double unit_interval(std::uint64_t bits) noexcept {
  return static_cast<double>(bits >> 11) * 0x1p-53;  // [0, 1)
}

double corner_value(std::int64_t x, std::int64_t y, std::int64_t z, std::uint64_t seed) noexcept {
  std::uint64_t hash = scramble(seed + kGolden);
  hash = scramble(hash ^ static_cast<std::uint64_t>(x) * kGolden);
  hash = scramble(hash ^ static_cast<std::uint64_t>(y) * kGolden);
  hash = scramble(hash ^ static_cast<std::uint64_t>(z) * kGolden);
  return 2 * unit_interval(hash) - 1;
}

double fade(double t) noexcept { return t * t * (3 - 2 * t); }

}  // namespace

std::uint64_t Random::next() noexcept { return scramble(state_ += kGolden); }

double Random::uniform(double lo, double hi) noexcept {
  return lo + (hi - lo) * unit_interval(next());
}

double smooth_noise(const Vec3& position, std::uint64_t seed) noexcept {
  const Vec3 floor = position.array().floor();
  const Vec3 t = (position - floor).unaryExpr(&fade);
  double value = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int x = corner & 1;
    const int y = (corner >> 1) & 1;
    const int z = corner >> 2;
    const double weight =
        (x ? t.x() : 1 - t.x()) * (y ? t.y() : 1 - t.y()) * (z ? t.z() : 1 - t.z());
    value += weight * corner_value(static_cast<std::int64_t>(floor.x()) + x,
                                   static_cast<std::int64_t>(floor.y()) + y,
                                   static_cast<std::int64_t>(floor.z()) + z, seed);
  }
  return value;
}

}  // namespace ovoid::model
