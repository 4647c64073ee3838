// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "ovoid/export.h"

namespace OVOID_API ovoid {

// Least and greatest value; empty (lo > hi) when there is no sample.
struct ValueRange {
  float lo = 1.0F;
  float hi = -1.0F;
  bool is_empty() const noexcept { return lo > hi; }
};

// The shared kernel of a lattice: phi(d) = exp(-1/2 sum_a (d_a / sigma)^2), d in lattice axes and
// in spacings of each axis. Its support is the BOX |d_a| <= cutoff * sigma. With the defaults that
// is exp(-2 r^2) cut at two spacings: four samples reach any position along each axis. Source:
// [Neophytou 2006, eq. 7], docs/numerics.md.
struct LatticeKernel {
  double sigma = 0.5;   // spacings, in [kMinSigma, kMaxSigma]
  double cutoff = 4.0;  // sigmas, in (0, kMaxCutoff]; support_radius() must be at least kMinSupport

  static constexpr double kMinSigma = 0.1;
  static constexpr double kMaxSigma = 4.0;
  static constexpr double kMaxCutoff = 16.0;
  static constexpr double kMinSupport = 0.5;  // below half a spacing the kernels leave gaps

  // Spacings. What misses a whole number by a cut-off's last typed digit, as 0.6 * 3.3333333 does,
  // is that number: else the taps at that distance would be lost on the planes of samples alone.
  double support_radius() const noexcept {
    const double radius = sigma * cutoff;
    const double whole = std::round(radius);
    return std::abs(radius - whole) <= kSupportRounding ? whole : radius;
  }
  static constexpr double kSupportRounding = 1e-6;

  bool operator==(const LatticeKernel&) const = default;
};

// How a field is summed from its kernels (docs/numerics.md, "The field").
enum class Reconstruction {
  kNormalized,  // sum w v phi / sum w phi over the kernels that exist; undefined where the
                // denominator is too small
  kSum,         // sum w v phi, with w = cell volume / integral of phi; fades to zero outside
};

}  // namespace ovoid
