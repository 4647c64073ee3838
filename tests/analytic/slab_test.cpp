// SPDX-License-Identifier: Apache-2.0
// The integrals of kernels over slabs: printed coefficients, quadrature, and what `mid` does
// instead.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "render/reference/field_evaluator.h"
#include "support/tolerances.h"
#include "support/volumes.h"

namespace ovoid::test {
namespace slab_test {

using reference::FieldEvaluator;
using reference::FieldSample;

FieldEvaluator single_kernel(Reconstruction reconstruction = Reconstruction::kSum) {
  FieldSetup setup;
  setup.reconstruction = reconstruction;
  return FieldEvaluator(constant_field({1, 1, 1}, 1, setup));
}

// Integral of exp(-2 z^2), cut at 2, over [z0, z0 + 1], through the centre of a kernel: the
// reference's mean slab, with its amplitude 1 / (pi / 2)^(3/2) taken out.
double slab_coefficient(const FieldEvaluator& kernel, double z0) {
  return kernel.mean_over({0, 0, z0}, {0, 0, z0 + 1}).value * std::pow(std::numbers::pi / 2, 1.5);
}

// Five slabs of thickness 1; the kernel's support [-2, 2] begins `offset` into the first.
std::array<double, 5> five_coefficients(double offset) {
  const FieldEvaluator kernel = single_kernel();
  std::array<double, 5> coefficients{};
  for (int s = 0; s < 5; ++s) {
    coefficients[static_cast<std::size_t>(s)] = slab_coefficient(kernel, -2 - offset + s);
  }
  return coefficients;
}

void expect_printed(const std::array<double, 5>& actual, const std::array<double, 5>& printed,
                    double tolerance) {
  for (std::size_t s = 0; s < 5; ++s) EXPECT_NEAR(actual[s], printed[s], tolerance) << "slab " << s;
}

// Fails if the limits of the box are not those of the integral, or erf is scaled wrongly.
TEST(Slab, CoefficientsAsPrinted) {
  expect_printed(five_coefficients(32 / 64.0), {0.0017, 0.1972, 0.8556, 0.1972, 0.0017},
                 kFourDigits);
  expect_printed(five_coefficients(0), {0.0285, 0.5981, 0.5981, 0.0285, 0}, kFourDigits);
}

TEST(Slab, CoefficientTableAsPrinted) {
  expect_printed(five_coefficients(0 / 64.0), {0.02847, 0.59814, 0.59814, 0.02847, 0}, kFiveDigits);
  expect_printed(five_coefficients(5 / 64.0), {0.01943, 0.52938, 0.66360, 0.04079, 0.00004},
                 kFiveDigits);
  expect_printed(five_coefficients(32 / 64.0), {0.00165, 0.19715, 0.85562, 0.19715, 0.00165},
                 kFiveDigits);
  expect_printed(five_coefficients(63 / 64.0), {0.00001, 0.03065, 0.61158, 0.58457, 0.02642},
                 kFiveDigits);
}

// Slabs fill the line: their integrals add up to sqrt(pi / 2) erf(4 / sqrt 2), wherever they are
// cut.
TEST(Slab, CoefficientsAddUpToTheWholeIntegral) {
  const double whole = std::sqrt(std::numbers::pi / 2) * std::erf(4 / std::numbers::sqrt2);
  EXPECT_NEAR(whole, 1.2532, kFourDigits);
  for (int c = 0; c < 64; ++c) {
    double sum = 0;
    for (const double coefficient : five_coefficients(c / 64.0)) sum += coefficient;
    ASSERT_NEAR(sum, whole, kDoubleRelative) << c;
  }
}

// The middle plane instead of the slab: 1.2353 to 1.2713, the ripple that `mean` is free of. On the
// samples two planes lie on the cut-off, which were printed whole and count half.
TEST(Slab, MiddlePlanesRippleAsPrinted) {
  const FieldEvaluator kernel = single_kernel();
  const auto sum_of_planes = [&](double offset) {
    double sum = 0;
    for (int s = -3; s <= 3; ++s) {
      sum += kernel.at_index({0, 0, s + offset}).value * std::pow(std::numbers::pi / 2, 1.5);
    }
    return sum;
  };
  EXPECT_NEAR(sum_of_planes(0) + std::exp(-8.0), 1.2713, kFourDigits);
  EXPECT_NEAR(sum_of_planes(0.5), 1.2353, kFourDigits);
  for (double offset = 0; offset < 1; offset += 0.01) {
    ASSERT_GE(sum_of_planes(offset), 1.2353 - kFourDigits);
    ASSERT_LE(sum_of_planes(offset), 1.2713 + kFourDigits);
  }
}

double wavy(std::int64_t i, std::int64_t j, std::int64_t k) {
  return 2 + std::sin(0.9 * static_cast<double>(i) + 0.5 * static_cast<double>(j)) +
         std::cos(1.1 * static_cast<double>(k) - 0.4 * static_cast<double>(j));
}

// Means of a sum along an oblique segment against Simpson's rule on its points. The cut-off is at 9
// sigmas, where the jumps (3e-18) do not disturb the rule; its error is (1 / 400)^4 / 180 of the
// fourth derivative, under 1e-9.
TEST(Slab, MeanOfASumIsItsIntegral) {
  FieldSetup setup;
  setup.kernel.cutoff = 9;
  setup.reconstruction = Reconstruction::kSum;
  const FieldEvaluator field(make_field({7, 6, 8}, wavy, setup));
  const Vec3 from(1.3, 4.1, 2.2);
  const Vec3 to(2.4, 3.2, 3.9);
  for (const Vec3& widening : {Vec3(1, 1, 1), Vec3(1.5, 1, 2)}) {
    constexpr int kIntervals = 400;
    double value = 0;
    Vec3 gradient = Vec3::Zero();
    for (int n = 0; n <= kIntervals; ++n) {
      const double weight = (n == 0 || n == kIntervals ? 1
                             : n % 2 == 1              ? 4
                                                       : 2) /
                            (3.0 * kIntervals);
      const FieldSample point = field.at_index(from + (to - from) * n / kIntervals, widening);
      value += weight * point.value;
      gradient += weight * point.gradient;
    }
    const FieldSample mean = field.mean_over(from, to, widening);
    EXPECT_NEAR(mean.value, value, 1e-9);
    EXPECT_NEAR((mean.gradient - gradient).norm(), 0, 1e-8);
    const FieldSample reversed = field.mean_over(to, from, widening);
    EXPECT_NEAR(reversed.value, mean.value, kDoubleRelative);
    EXPECT_NEAR((reversed.gradient - mean.gradient).norm(), 0, 10 * kDoubleRelative);
  }
}

// A normalized mean is the quotient of two integrals, and not the mean of quotients: it equals the
// ratio of the means of two sums, one of the values and one of ones. With holes and beyond a face,
// where the two differ.
TEST(Slab, NormalizedMeanIsTheQuotientOfIntegrals) {
  const auto with_hole = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    return i == 3 && j == 3 && k <= 3 ? kMissing : wavy(i, j, k);
  };
  const auto ones = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return std::isnan(with_hole(i, j, k)) ? kMissing : 1.0;
  };
  FieldSetup setup;
  const FieldEvaluator normalized(make_field({7, 7, 7}, with_hole, setup));
  setup.reconstruction = Reconstruction::kSum;
  const FieldEvaluator numerator(make_field({7, 7, 7}, with_hole, setup));
  const FieldEvaluator denominator(make_field({7, 7, 7}, ones, setup));
  int num_defined = 0;
  for (double x = -0.75; x < 7; x += 0.31) {
    const Vec3 from(x, 2.9, 2.6);
    const Vec3 to(x + 0.5, 3.3, 3.4);
    const FieldSample mean = normalized.mean_over(from, to);
    if (!mean.is_defined) continue;
    ++num_defined;
    const FieldSample n = numerator.mean_over(from, to);
    const FieldSample d = denominator.mean_over(from, to);
    EXPECT_NEAR(mean.value, n.value / d.value, kDoubleRelative * 4);
    const Vec3 gradient = (n.gradient - mean.value * d.gradient) / d.value;
    EXPECT_NEAR((mean.gradient - gradient).norm(), 0, 100 * kDoubleRelative);
  }
  EXPECT_GT(num_defined, 15);
}

// Short segments come to the point's value: with length e the mean differs by e^2 / 24 times the
// second derivative (16 for a kernel of 1), until rounding (eps / e) takes over.
TEST(Slab, MeanOfAShortSegmentIsThePoint) {
  const FieldEvaluator field(make_field({7, 6, 8}, wavy));
  const Vec3 middle(2.83, 3.17, 4.39);
  const Vec3 direction = Vec3(0.3, -0.5, 0.8).normalized();
  const FieldSample point = field.at_index(middle);
  for (const double length : {1e-2, 1e-4, 1e-6}) {
    const FieldSample mean =
        field.mean_over(middle - 0.5 * length * direction, middle + 0.5 * length * direction);
    EXPECT_NEAR(mean.value, point.value, 20 * length * length + 1e-15 / length) << length;
    EXPECT_NEAR((mean.gradient - point.gradient).norm(), 0, 200 * length * length + 1e-14 / length);
  }
}

// A segment that meets no support box, and one that grazes nothing but holes.
TEST(Slab, NothingInReachIsUndefined) {
  const FieldEvaluator kernel = single_kernel();
  EXPECT_FALSE(kernel.mean_over({0, 0, 2.01}, {0, 0, 3}).is_defined);
  EXPECT_FALSE(kernel.mean_over({2.01, 0, -1}, {2.01, 0, 1}).is_defined);
  EXPECT_TRUE(kernel.mean_over({1.99, 0, -1}, {1.99, 0, 1}).is_defined);
  const FieldEvaluator empty(constant_field({3, 3, 3}, kMissing));
  EXPECT_FALSE(empty.mean_over({1, 1, 0}, {1, 1, 2}).is_defined);
  EXPECT_FALSE(empty.at_index({1, 1, 1}).is_defined);
  EXPECT_EQ(empty.num_existing(), 0);
}

}  // namespace slab_test
}  // namespace ovoid::test
