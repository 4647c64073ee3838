// SPDX-License-Identifier: Apache-2.0
// What the sum of a lattice's kernels is where all values are 1: the ripple of the plain method,
// and its absence from normalized fields. A wrong sigma, cut-off, normalisation or lattice range
// moves every number here.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/reference/field_evaluator.h"
#include "support/tolerances.h"
#include "support/volumes.h"

namespace ovoid::test {
namespace kernel_sums_test {

using reference::FieldEvaluator;
using reference::FieldSample;

struct Extremes {
  double least = 1e300;
  double greatest = -1e300;

  void add(double value) {
    least = std::min(least, value);
    greatest = std::max(greatest, value);
  }
  double ripple(double mean) const { return (greatest - least) / mean; }
};

// Sum of exp(-beta r^2), cut by the BALL of `radius` as the published method has it, over the
// Cartesian lattice of spacing 1 or the body-centred one of equal sampling density for T = 1 (two
// Cartesian ones of spacing sqrt 2).
Extremes ball_sums(double beta, double radius, bool is_body_centred) {
  // Samples, cell centres, face and edge middles are all among 16 steps of half a cell; between the
  // jumps at the cut-off the sum is smooth.
  constexpr int kSteps = 16;
  const double spacing = is_body_centred ? std::numbers::sqrt2 : 1.0;
  const auto sum_at = [&](double x, double y, double z) {
    double sum = 0;
    for (int shift = 0; shift < (is_body_centred ? 2 : 1); ++shift) {
      for (int k = -4; k <= 4; ++k) {
        for (int j = -4; j <= 4; ++j) {
          for (int i = -4; i <= 4; ++i) {
            const Vec3 center = spacing * (Vec3(i, j, k) + 0.5 * shift * Vec3::Ones());
            const double r2 = (Vec3(x, y, z) - center).squaredNorm();
            if (r2 <= radius * radius + 1e-9) sum += std::exp(-beta * r2);
          }
        }
      }
    }
    return sum;
  };
  // One of the 48 equal parts of a cell.
  Extremes extremes;
  for (int a = 0; a <= kSteps; ++a) {
    for (int b = 0; b <= a; ++b) {
      for (int c = 0; c <= b; ++c) {
        const double step = spacing / (2 * kSteps);
        extremes.add(sum_at(a * step, b * step, c * step));
      }
    }
  }
  return extremes;
}

double integral_of(double beta) { return std::pow(std::numbers::pi / beta, 1.5); }

TEST(KernelSums, PublishedRippleOfTheCartesianLattice) {
  const Extremes narrow = ball_sums(2.0, 2.0, false);
  EXPECT_NEAR(narrow.least, 1.8831, kFourDigits);
  EXPECT_NEAR(narrow.greatest, 2.0536, kFourDigits);
  EXPECT_NEAR(integral_of(2.0), 1.96870, kFiveDigits);
  EXPECT_NEAR(narrow.ripple(integral_of(2.0)), 0.087, 0.0005);
  EXPECT_NEAR(ball_sums(1.5, 2.5, false).ripple(integral_of(1.5)), 0.017, 0.0005);
  EXPECT_NEAR(ball_sums(1.0, 3.0, false).ripple(integral_of(1.0)), 0.0008, 0.00005);
}

TEST(KernelSums, PublishedRippleOfTheBodyCentredLattice) {
  const double density = 1 / std::numbers::sqrt2;  // samples per volume
  const Extremes narrow = ball_sums(2.0, 2.0, true);
  EXPECT_NEAR(narrow.least, 1.3500, kFourDigits);
  EXPECT_NEAR(narrow.greatest, 1.5122, kFourDigits);
  EXPECT_NEAR(integral_of(2.0) * density, 1.39208, kFiveDigits);
  EXPECT_NEAR(narrow.ripple(integral_of(2.0) * density), 0.117, 0.0005);
  EXPECT_NEAR(ball_sums(1.5, 2.5, true).ripple(integral_of(1.5) * density), 0.023, 0.0005);
}

// One axis of the box-cut kernel: 1 + 2 e^-2 + e^-8 on a sample, as the two at the cut-off count
// half, 2 e^-1/2 + 2 e^-9/2 between two.
TEST(KernelSums, BoxCutSumIsTheProductOfItsAxes) {
  FieldSetup setup;
  setup.reconstruction = Reconstruction::kSum;
  const FieldEvaluator field(constant_field({9, 9, 9}, 1, setup));
  const double on = 1 + 2 * std::exp(-2.0) + std::exp(-8.0);
  const double between = 2 * std::exp(-0.5) + 2 * std::exp(-4.5);
  EXPECT_NEAR(on + std::exp(-8.0), 1.2713, kFourDigits);  // printed with both whole
  EXPECT_NEAR(between, 1.2353, kFourDigits);
  const double full = integral_of(2.0);
  EXPECT_NEAR(field.at_index({4, 4, 4}).value * full, on * on * on, kDoubleRelative * full);
  EXPECT_NEAR(field.at_index({4.5, 4, 4}).value * full, between * on * on, kDoubleRelative * full);
  EXPECT_NEAR(field.at_index({4.5, 3.5, 4.5}).value * full, between * between * between,
              kDoubleRelative * full);

  Extremes extremes;
  for (int a = 0; a <= 32; ++a) {
    for (int b = 0; b <= 32; ++b) {
      for (int c = 0; c <= 32; ++c) {
        extremes.add(field.at_index({4 + a / 32.0, 4 + b / 32.0, 4 + c / 32.0}).value * full);
      }
    }
  }
  EXPECT_NEAR(extremes.least, between * between * between, kDoubleRelative * full);
  EXPECT_NEAR(extremes.greatest, on * on * on, kDoubleRelative * full);
}

// Fails if numerator and denominator are not summed over the same kernels with the same weights.
// Fails if a sublattice is left out of a sum, or a cell is taken to hold one sample: the published
// ripple, which a box instead of a ball at the cut-off changes by less than one in a thousand.
TEST(KernelSums, BodyCentredFieldOfOnesHasThePublishedRipple) {
  FieldSetup setup;
  setup.lattice = LatticeKind::kBodyCentred;
  setup.reconstruction = Reconstruction::kSum;
  const FieldEvaluator evaluator(constant_field({9, 9, 18}, 1.0, setup));
  Extremes extremes;
  constexpr int kSteps = 16;
  for (int a = 0; a <= kSteps; ++a) {
    for (int b = 0; b <= kSteps; ++b) {
      for (int c = 0; c <= kSteps; ++c)
        extremes.add(evaluator.at_index(Vec3(4, 4, 4) + Vec3(a, b, c) / kSteps).value);
    }
  }
  const double mean = integral_of(2.0) / std::numbers::sqrt2;
  EXPECT_NEAR(extremes.least * mean, 1.3500, 2e-3);
  EXPECT_NEAR(extremes.greatest * mean, 1.5122, 2e-3);
}

TEST(KernelSums, NormalizedConstantIsConstant) {
  for (const double sigma : {0.5, 0.7, 1.3}) {
    FieldSetup setup;
    setup.world_from_index = oblique_axes();
    setup.kernel.sigma = sigma;
    const FieldEvaluator field(constant_field({11, 9, 10}, 731.25, setup));
    int num_defined = 0;
    for (double x = -1; x < 11.5; x += 0.57) {
      for (double y = -1; y < 9.5; y += 0.61) {
        for (double z = -1; z < 10.5; z += 0.63) {
          for (const double m : {1.0, 1.9}) {
            const FieldSample sample = field.at_index({x, y, z}, {m, 1, m});
            if (!sample.is_defined) continue;
            ++num_defined;
            ASSERT_NEAR(sample.value, 731.25, 731.25 * kDoubleRelative)
                << x << " " << y << " " << z;
            ASSERT_LE(sample.gradient.norm(), 731.25 * 10 * kDoubleRelative);
          }
        }
      }
    }
    EXPECT_GT(num_defined, 4000);
  }
}

// A field of one more kind of kernel: the sum on a lattice with a large sigma is free of ripple, so
// its weight must be 1 / ((2 pi)^(3/2) sigma^3) and nothing else. The cut of 6 sigmas leaves out
// 1e-8, ripple is 2 exp(-2 pi^2 sigma^2).
TEST(KernelSums, WeightMakesWideSumsOfOnesOne) {
  FieldSetup setup;
  setup.reconstruction = Reconstruction::kSum;
  setup.kernel = {1.25, 6.0};
  const FieldEvaluator field(constant_field({24, 24, 24}, 1, setup));
  for (const double t : {0.0, 0.2, 0.5}) {
    EXPECT_NEAR(field.at_index({11 + t, 11.3, 12 - t}).value, 1.0, 1e-7);
  }
  // Widened, the same: amplitudes are divided by the product of the factors.
  EXPECT_NEAR(field.at_index({11.5, 11.5, 11.5}, {1.3, 1.1, 1.2}).value, 1.0, 1e-7);
}

}  // namespace kernel_sums_test
}  // namespace ovoid::test
