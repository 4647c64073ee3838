// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "ovoid/look.h"
#include "support/kernel_sets.h"
#include "support/volumes.h"

namespace ovoid {
namespace projection_look_test {

constexpr std::int64_t kProjected = 64;

double distance_from_middle(std::int64_t i, std::int64_t j, std::int64_t k) {
  const double c = 0.5 * (kProjected - 1);
  return std::hypot(static_cast<double>(i) - c, static_cast<double>(j) - c,
                    static_cast<double>(k) - c);
}

template <class Value>
TransferFunction projected(Mode mode, const Value& value) {
  return projection_look(test::make_field({kProjected, kProjected, kProjected}, value), mode)
      .transfer_function;
}

// Rays through a ball of 100 in a background of 7.
TEST(ProjectionLook, SpansWhatRaysShow) {
  const auto ball = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    const double r = distance_from_middle(i, j, k);
    return r < 24 ? 60 + 40 * (1 - r / 24) : 7;
  };
  const TransferFunction most = projected(Mode::kMaximum, ball);
  EXPECT_EQ(most.scale, ValueScale::kLinear);
  EXPECT_GE(most.lo(), 7);
  EXPECT_LT(most.lo(), 60);
  // The 2 % of its rays that are brightest come nearer to its middle than 0.14 of its radius.
  EXPECT_NEAR(most.hi(), 94.3, 1.5);
  // Nearly every ray ends outside of the ball.
  const TransferFunction least = projected(Mode::kMinimum, ball);
  EXPECT_LE(least.lo(), 7);
  const TransferFunction mean = projected(Mode::kMean, ball);
  EXPECT_LT(mean.hi(), most.hi());
  EXPECT_GT(mean.hi(), 7);
}

// Fails if what few rays show makes all others dark.
TEST(ProjectionLook, FewBrightRaysDoNotMakeTheRestDark) {
  const TransferFunction tf =
      projected(Mode::kMaximum, [](std::int64_t i, std::int64_t j, std::int64_t k) {
        if (i == 30 && j == 9 && k == 50) return 5000.0;
        return 100 - distance_from_middle(i, j, k);
      });
  EXPECT_NEAR(tf.hi(), 100, 10);
}

TEST(ProjectionLook, HeavyTailsAreLogarithmic) {
  const TransferFunction tf =
      projected(Mode::kMaximum, [](std::int64_t i, std::int64_t j, std::int64_t k) {
        return std::pow(0.5 + distance_from_middle(i, j, k) / 8, -8);
      });
  EXPECT_EQ(tf.scale, ValueScale::kLog);
  EXPECT_GE(tf.lo() * 1e4 * 1.001, tf.hi());
  // As negative values, which have no logarithm, linear.
  EXPECT_EQ(projected(Mode::kMaximum,
                      [](std::int64_t i, std::int64_t j, std::int64_t k) {
                        return std::pow(0.5 + distance_from_middle(i, j, k) / 8, -8) - 1;
                      })
                .scale,
            ValueScale::kLinear);
}

TEST(ProjectionLook, LatticesWithMissingSamples) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const TransferFunction tf =
      projected(Mode::kMaximum, [&](std::int64_t i, std::int64_t j, std::int64_t k) {
        return j < 40 ? double{nan} : static_cast<double>(i + k);
      });
  EXPECT_GE(tf.lo(), 0);
  EXPECT_NEAR(tf.hi(), 2 * (kProjected - 1), 10);
  EXPECT_EQ(projected(Mode::kMinimum, [](auto...) { return 3.0; }).scale, ValueScale::kLinear);
}

TEST(ProjectionLook, KernelSets) {
  for (const Reconstruction sum : {Reconstruction::kNormalized, Reconstruction::kSum}) {
    test::KernelNumbers numbers = test::jittered_balls(10);
    numbers.values[0][17] = 1e6F;
    const KernelField field(numbers.source(), sum);
    for (const Mode mode : {Mode::kMaximum, Mode::kMinimum, Mode::kMean}) {
      const TransferFunction tf = projection_look(field, mode).transfer_function;
      EXPECT_LT(tf.lo(), tf.hi());
      EXPECT_LT(tf.hi(), 1e5);
    }
  }
}

TEST(ProjectionLook, EmptyFieldsAreRefused) {
  EXPECT_ANY_THROW(projection_look(Field(), Mode::kMaximum));
}

}  // namespace projection_look_test
}  // namespace ovoid
