// SPDX-License-Identifier: Apache-2.0
// The filters of post-convolution, read as C++ and as GLSL (docs/numerics.md, "Post-convolution").
// The reference back end has its own.
#ifndef OVOID_RENDER_SHARED_FILTER_FORMULAS_H_
#define OVOID_RENDER_SHARED_FILTER_FORMULAS_H_

#ifdef __cplusplus
#pragma once
#endif

#include "render/shared/device_layout.h"

#ifdef __cplusplus
#include <cmath>

namespace ovoid::device {

using std::abs;
using std::exp;
using real = double;  // GLSL's name of it. NOLINT(readability-identifier-naming)
#define OVOID_FORMULA inline
#else
#define real float
#define OVOID_FORMULA
#endif

// The weight, before the weights are made to add up to 1, of sample k - kTapsBefore for a place
// that lies `phase`, in [0, 1), behind sample 0. Samples are a distance of 1 apart. Lagrange's
// weights go through all six samples: they are exact on polynomials of degree 5. The published
// filters are functions of the distance.
OVOID_FORMULA real filter_weight(uint filter_number, int k, real phase) {
  if (filter_number == kFilterLagrange) {
    real weight = 1.0;
    for (int m = 0; m < kFilterTaps; ++m) {
      if (m != k) weight *= (phase - real(m - kTapsBefore)) / real(k - m);
    }
    return weight;
  }
  real x = abs(real(k - kTapsBefore) - phase);
  if (filter_number == kFilterBilinear) return x < 1.0 ? 1.0 - x : 0.0;
  if (filter_number == kFilterGaussian) return x < 2.0 ? exp(-2.0 * x * x) : 0.0;
  if (x < 1.0) return (1.5 * x - 2.5) * x * x + 1.0;  // Keys, a = -1/2
  return x < 2.0 ? ((-0.5 * x + 2.5) * x - 4.0) * x + 2.0 : 0.0;
}

#ifdef __cplusplus
}  // namespace ovoid::device
#endif
#undef OVOID_FORMULA
#endif
