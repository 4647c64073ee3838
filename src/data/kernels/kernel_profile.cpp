// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>

#include "ovoid/kernel_field.h"

namespace ovoid {

const char* name_of(KernelProfile profile) noexcept {
  switch (profile) {
    case KernelProfile::kGaussian:
      return "gaussian";
    case KernelProfile::kCubicSpline:
      return "cubic-spline";
    case KernelProfile::kWendlandC2:
      return "wendland";
    case KernelProfile::kEpanechnikov:
      return "epanechnikov";
  }
  return "gaussian";
}

double profile_value(KernelProfile profile, double m, double cutoff) noexcept {
  if (!(m <= cutoff)) return 0.0;
  const double t = m / cutoff;
  switch (profile) {
    case KernelProfile::kGaussian:
      return std::exp(-0.5 * m * m) -
             std::exp(-0.5 * cutoff * cutoff) * (1 + 0.5 * (cutoff * cutoff - m * m));
    case KernelProfile::kCubicSpline: {
      const double q = 2 * t;
      return q < 1 ? 1 - 1.5 * q * q + 0.75 * q * q * q : 0.25 * std::pow(2 - q, 3);
    }
    case KernelProfile::kWendlandC2:
      return std::pow(1 - t, 4) * (1 + 4 * t);
    case KernelProfile::kEpanechnikov:
      return 1 - t * t;
  }
  return 0.0;
}

// 4 pi times the integral of t^2 profile(t) over [0, 1], times the support radius cubed.
double profile_integral(KernelProfile profile, double cutoff) noexcept {
  using std::numbers::pi;
  const double cube = cutoff * cutoff * cutoff;
  switch (profile) {
    case KernelProfile::kGaussian: {
      const double at_end = std::exp(-0.5 * cutoff * cutoff);
      const double inside =
          std::pow(2 * pi, 1.5) * std::erf(cutoff / std::numbers::sqrt2) - 4 * pi * cutoff * at_end;
      return inside - 4 * pi * cube * at_end * (1.0 / 3 + cutoff * cutoff / 15);
    }
    case KernelProfile::kCubicSpline:
      return pi / 8 * cube;
    case KernelProfile::kWendlandC2:
      return 2 * pi / 21 * cube;
    case KernelProfile::kEpanechnikov:
      return 8 * pi / 15 * cube;
  }
  return 1.0;
}

}  // namespace ovoid
