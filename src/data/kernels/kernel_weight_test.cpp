// SPDX-License-Identifier: Apache-2.0
#include "data/kernels/kernel_weight.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ovoid/lattice.h"

namespace ovoid::data {
namespace kernel_weight_test {

constexpr LatticeKernel kPiecewise[] = {kBSplineKernel, kCatmullRomKernel};

// Fails if a piece has another coefficient: constants and ramps are then not reproduced.
TEST(KernelWeight, PiecesReproduceConstantsAndRamps) {
  for (const LatticeKernel& kernel : kPiecewise) {
    for (double u = 0; u <= 1; u += 0.01) {
      double sum = 0;
      double first = 0;
      for (int i = -2; i <= 3; ++i) {
        sum += axis_weight(kernel, u - i);
        first += i * axis_weight(kernel, u - i);
      }
      EXPECT_NEAR(sum, 1, 1e-12) << name_of(kernel.kind) << " at " << u;
      EXPECT_NEAR(first, u, 1e-12) << name_of(kernel.kind) << " at " << u;
    }
  }
}

// Fails if the two pieces do not meet, with slopes, and a B-spline with curvatures.
TEST(KernelWeight, PiecesAreAsSmoothAsTheySay) {
  constexpr double h = 1e-4;
  for (const LatticeKernel& kernel : kPiecewise) {
    const auto g = [&](double d) { return axis_weight(kernel, d); };
    for (const double knot : {-2.0, -1.0, 0.0, 1.0, 2.0}) {
      const double behind = (g(knot + h) - g(knot)) / h;
      const double before = (g(knot) - g(knot - h)) / h;
      EXPECT_NEAR(behind, before, 1e-3) << name_of(kernel.kind) << " at " << knot;
      if (kernel.kind != LatticeKernelKind::kBSpline) continue;
      const double curve_behind = (g(knot + 2 * h) - 2 * g(knot + h) + g(knot)) / (h * h);
      const double curve_before = (g(knot) - 2 * g(knot - h) + g(knot - 2 * h)) / (h * h);
      EXPECT_NEAR(curve_behind, curve_before, 1e-3) << "at " << knot;
    }
  }
}

// Fails if the mass is another: `sum` would then change the level.
TEST(KernelWeight, MassIsTheIntegral) {
  for (const LatticeKernel& kernel : {LatticeKernel{}, kBSplineKernel, kCatmullRomKernel}) {
    double integral = 0;
    constexpr double kStep = 1e-3;
    for (double d = -2 + kStep / 2; d < 2; d += kStep) integral += kStep * axis_weight(kernel, d);
    EXPECT_NEAR(integral, axis_mass(kernel), 1e-4 * axis_mass(kernel)) << name_of(kernel.kind);
  }
}

// Fails if a place has weights whose negative part is more than the bound says: relevance would
// leave holes. Widened, at a face and in between.
TEST(KernelWeight, OvershootIsBounded) {
  const double along_axis = std::cbrt(1 + 2 * overshoot_of(kCatmullRomKernel, true));
  for (double widening = 1; widening < 3.5; widening += 0.05) {
    for (double u = -0.55 * widening; u < 4; u += 0.02) {
      double all = 0, existing = 0, magnitudes = 0;
      for (int i = -12; i <= 16; ++i) {
        const double w = axis_weight(kCatmullRomKernel, (u - i) / widening);
        all += w;
        existing += i < 0 ? 0 : w;
        magnitudes += i < 0 ? 0 : std::abs(w);
      }
      if (existing < 0.42 * all) continue;
      EXPECT_LE(magnitudes / existing, along_axis);
    }
  }
  EXPECT_EQ(overshoot_of(kBSplineKernel, false), 0);
}

}  // namespace kernel_weight_test
}  // namespace ovoid::data
