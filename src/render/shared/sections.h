// SPDX-License-Identifier: Apache-2.0
// Pre-integrated sections of a Gaussian. Plain scalar formulas, for every back end but the
// reference, which has its own.
#pragma once

#include <cmath>

#include "render/shared/moment_formulas.h"

namespace ovoid {

using device::SlabMoments;

// Double inside: far from the middle the weight is a small difference. Slabs without weight have
// their middle as their mean.
inline SlabMoments slab_moments(double a, double b) {
  constexpr double kSqrtHalfPi = 1.2533141373155003;
  constexpr double kSqrtHalf = 0.70710678118654752;
  const double weight = kSqrtHalfPi * (std::erf(b * kSqrtHalf) - std::erf(a * kSqrtHalf));
  if (!(weight > 1e-12)) return {0.0F, static_cast<float>(0.5 * (a + b)), 0.0F};
  const double at_a = std::exp(-0.5 * a * a);
  const double at_b = std::exp(-0.5 * b * b);
  const double mean = (at_a - at_b) / weight;
  const double variance = 1.0 + (a * at_a - b * at_b) / weight - mean * mean;
  return {static_cast<float>(weight), static_cast<float>(mean),
          static_cast<float>(variance > 0 ? variance : 0.0)};
}

}  // namespace ovoid
