// SPDX-License-Identifier: Apache-2.0
// The filters of post-convolution, for every back end but the reference, which has its own: the
// weights of samples a distance of 1 apart for a place between them (docs/numerics.md,
// "Post-convolution").
#pragma once

#include <array>
#include <cmath>

#include "ovoid/render_options.h"

namespace ovoid {

// Samples at -kTapsBefore, ..., +3 from the one at or before the place.
inline constexpr int kFilterTaps = 6;
inline constexpr int kTapsBefore = 2;
using FilterTaps = std::array<double, kFilterTaps>;

// Through all six: exact on polynomials of degree 5.
inline FilterTaps lagrange_taps(double phase) {
  FilterTaps taps{};
  for (int k = 0; k < kFilterTaps; ++k) {
    double weight = 1;
    for (int m = 0; m < kFilterTaps; ++m) {
      if (m != k) weight *= (phase - (m - kTapsBefore)) / (k - m);
    }
    taps[static_cast<std::size_t>(k)] = weight;
  }
  return taps;
}

// The published filters as functions of the distance.
inline double published_filter(PostConvolution how, double distance) {
  const double x = std::abs(distance);
  if (how == PostConvolution::kBilinear) return x < 1 ? 1 - x : 0.0;
  if (how == PostConvolution::kGaussian) return x < 2 ? std::exp(-2 * x * x) : 0.0;
  if (x < 1) return (1.5 * x - 2.5) * x * x + 1;  // Keys, a = -1/2
  return x < 2 ? ((-0.5 * x + 2.5) * x - 4) * x + 2 : 0.0;
}

// `phase`: of the place behind sample 0, in [0, 1). The weights' sum is 1.
inline FilterTaps filter_taps(PostConvolution how, double phase) {
  if (how == PostConvolution::kAuto) return lagrange_taps(phase);
  FilterTaps taps{};
  double sum = 0;
  for (int k = 0; k < kFilterTaps; ++k)
    sum += taps[static_cast<std::size_t>(k)] = published_filter(how, k - kTapsBefore - phase);
  for (double& weight : taps) weight /= sum;
  return taps;
}

}  // namespace ovoid
