// SPDX-License-Identifier: Apache-2.0
// The order of what docs/numerics.md compares, on the same places.
#include "experiments/kernel_choice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace ovoid::experiments {
namespace kernel_choice_test {

constexpr int kNumPoints = 1000;

// Fails if the prefilter does not interpolate, or the field is not as smooth as its kernels.
TEST(KernelChoice, PrefilteredIsNearerThanTrilinearAndThatThanThePlainSum) {
  const KernelErrors prefiltered = measure_kernel(normalized_choice(0.6, 2, true), kNumPoints);
  const KernelErrors trilinear = measure_trilinear(kNumPoints);
  const KernelErrors plain = measure_kernel(published_choice(), kNumPoints);
  EXPECT_LT(prefiltered.rms, 0.6 * trilinear.rms);
  EXPECT_LT(trilinear.rms, plain.rms);
  EXPECT_LT(prefiltered.exact_deg, 0.5 * trilinear.exact_deg);
  EXPECT_LT(trilinear.exact_deg, plain.exact_deg);
}

// Fails if the default loses what it was chosen for: 3 dB over trilinear interpolation and more, a
// quarter cycle per sample all but whole, ramps as they are, and no more overshoot than a cubic
// spline has.
TEST(KernelChoice, TheDefaultIsTheSpline) {
  const KernelErrors spline = measure_kernel(default_choice(), kNumPoints);
  EXPECT_LT(spline.rms, 0.5 * measure_trilinear(kNumPoints).rms);
  EXPECT_GT(spline.quarter, 0.97);
  EXPECT_LT(spline.ramp_deg, 0.2);
  EXPECT_LT(spline.overshoot, 0.115);
  const KernelErrors catmull_rom = measure_kernel(catmull_rom_choice(), kNumPoints);
  EXPECT_LT(catmull_rom.rms, 0.75 * measure_trilinear(kNumPoints).rms);
  EXPECT_GT(catmull_rom.quarter, 0.92);
}

// A linear interpolant is the samples convolved with a tent, whose transform is sinc^2: 8 / pi^2 at
// a quarter of the sampling rate. The projection of a sampled wave on itself has no other part
// there.
TEST(KernelChoice, TransferOfTheTentIsSincSquared) {
  constexpr double kExpected = 8 / (std::numbers::pi * std::numbers::pi);
  EXPECT_NEAR(measure_trilinear(10).quarter, kExpected, 1e-4);
}

// [METHOD 1.4]: the sum of the kernels of a constant lies between -4.3 and +4.3 % of its mean; over
// 3 axes with 2 exp(-pi^2 / 2) each, (1 + 0.0144)^3 - (1 - 0.0144)^3 = 0.0864.
TEST(KernelChoice, RippleIsThePlainSumsAlone) {
  EXPECT_NEAR(measure_kernel(published_choice(), kNumPoints).ripple, 0.0864, 1e-3);
  EXPECT_LT(measure_kernel(default_choice(), kNumPoints).ripple, 1e-6);  // coefficients are floats
}

}  // namespace kernel_choice_test
}  // namespace ovoid::experiments
