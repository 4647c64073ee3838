// SPDX-License-Identifier: Apache-2.0
// Known answers, on other shapes, values and noise than those that thresholds were chosen on.
#include "view/look/joint_histogram.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/kernel_sets.h"
#include "support/volumes.h"

namespace ovoid {
namespace joint_histogram_test {

constexpr std::int64_t kJointSide = 56;

// Evenly spread over [0, 1), by place and seed alone.
double evenly(std::int64_t i, std::int64_t j, std::int64_t k, std::uint64_t seed) {
  auto x = static_cast<std::uint64_t>((k * kJointSide + j) * kJointSide + i) + seed * 0x1000003U;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebU;
  x ^= x >> 31;
  return (static_cast<double>(x >> 11) + 0.5) * 0x1p-53;
}

// Normally distributed, with a deviation of 1.
double normally(std::int64_t i, std::int64_t j, std::int64_t k, std::uint64_t seed) {
  return std::sqrt(-2 * std::log(evenly(i, j, k, seed))) *
         std::cos(2 * std::acos(-1.0) * evenly(i, j, k, seed + 1));
}

double step_at(double distance) { return 1 / (1 + std::exp(-2 * distance)); }

// A slab and a rod along y in it.
double slab_with_a_rod(std::int64_t i, std::int64_t k) {
  const double from_middle = std::abs(static_cast<double>(k) - 28);
  const double from_axis = std::hypot(static_cast<double>(i) - 28, static_cast<double>(k) - 28);
  return -3 + 4.5 * step_at(15 - from_middle) + 5.5 * step_at(9 - from_axis);
}

LatticeField materials_with_noise(double noise, double factor = 1) {
  return test::make_field({kJointSide, kJointSide, kJointSide},
                          [=](std::int64_t i, std::int64_t j, std::int64_t k) {
                            return factor * (slab_with_a_rod(i, k) + noise * normally(i, j, k, 5));
                          });
}

TEST(Materials, AndTheirBoundariesAreFoundInNoise) {
  for (const double noise : {0.0, 0.2, 0.6}) {
    for (const double factor : {1.0, 1e-9}) {
      const Materials found = materials_of(materials_with_noise(noise, factor));
      ASSERT_EQ(found.values.size(), 3) << "noise " << noise;
      ASSERT_EQ(found.boundaries.size(), 2);
      const double tolerance = 0.03 * 10 * factor;
      EXPECT_NEAR(found.values[0], -3 * factor, tolerance);
      EXPECT_NEAR(found.values[1], 1.5 * factor, tolerance);
      EXPECT_NEAR(found.values[2], 7 * factor, tolerance);
      // The middle half of the way: noise decides where in it.
      EXPECT_NEAR(found.boundaries[0], -0.75 * factor, 1.2 * factor);
      EXPECT_NEAR(found.boundaries[1], 4.25 * factor, 1.4 * factor);
      // Three differences over two spacings, each of a deviation of 1 / sqrt(2): the median of
      // their length is 1.09.
      EXPECT_NEAR(found.noise, 1.09 * noise * factor, 0.15 * noise * factor);
      EXPECT_EQ(found.noisiness, 0);
    }
  }
}

// Smoothed complex noise has lengths with Rayleigh's distribution, as echoes have.
double speckle(std::int64_t i, std::int64_t j, std::int64_t k) {
  double re = 0;
  double im = 0;
  for (std::int64_t dk = 0; dk < 2; ++dk) {
    for (std::int64_t dj = 0; dj < 2; ++dj) {
      for (std::int64_t di = 0; di < 2; ++di) {
        re += normally(i + di, j + dj, k + dk, 11);
        im += normally(i + di, j + dj, k + dk, 23);
      }
    }
  }
  return std::hypot(re, im);
}

TEST(Materials, SpeckleIsNoisyWhateverItFills) {
  const auto in_box = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    return (j < 28 ? 1.0 : 2.0) * speckle(i, j, k);
  };
  EXPECT_GT(materials_of(test::make_field({kJointSide, kJointSide, kJointSide}, in_box)).noisiness,
            0.9);
  const auto in_cone = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    const bool is_in = std::hypot(static_cast<double>(i) - 28, static_cast<double>(j) - 28) <
                       0.5 * static_cast<double>(k);
    return is_in ? in_box(i, j, k) : 0.0;
  };
  EXPECT_GT(materials_of(test::make_field({kJointSide, kJointSide, kJointSide}, in_cone)).noisiness,
            0.9);
}

// Counts of a few photons, a fluorescent shell in the dark.
TEST(Materials, PhotonNoiseIsNoisy) {
  const auto counts = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    const double r = std::hypot(static_cast<double>(i) - 28, static_cast<double>(j) - 28,
                                static_cast<double>(k) - 28);
    const double expected = 0.5 + (r > 12 && r < 20 ? 3.0 : 0.0);
    double count = 0;
    for (double rest = std::exp(expected); rest > 1 && count < 30; ++count)
      rest *= evenly(i, j, k, 31 + static_cast<std::uint64_t>(count));
    return count;
  };
  EXPECT_GT(materials_of(test::make_field({kJointSide, kJointSide, kJointSide}, counts)).noisiness,
            0.5);
}

TEST(Materials, SmoothFieldsAndWavesAreNotNoisy) {
  const auto hill = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    return std::exp(-0.01 * static_cast<double>((i - 25) * (i - 25) + (j - 30) * (j - 30) +
                                                (k - 20) * (k - 20)));
  };
  const auto waves = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    return std::sin(1.5 * static_cast<double>(i)) + 0.1 * static_cast<double>(j - k);
  };
  for (const auto& function : {test::VolumeFunction(hill), test::VolumeFunction(waves)}) {
    const Materials found =
        materials_of(test::make_field({kJointSide, kJointSide, kJointSide}, function));
    EXPECT_EQ(found.noise, 0);
    EXPECT_EQ(found.noisiness, 0);
  }
}

TEST(Materials, RampsGoOneWayAndClosedThingsDoNot) {
  const LatticeField ramp =
      test::make_field({40, 30, 20}, [](std::int64_t i, std::int64_t j, std::int64_t k) {
        return static_cast<double>(2 * i + j) - 0.5 * static_cast<double>(k);
      });
  EXPECT_NEAR(view::one_sidedness(data::take_rises(ramp.samples())), 1, 1e-6);
  EXPECT_LT(view::one_sidedness(data::take_rises(materials_with_noise(0.1).samples())), 0.1);
  EXPECT_EQ(view::one_sidedness({}), 0);
}

TEST(Materials, NothingIsFoundInTooLittle) {
  const Field fields[] = {
      test::constant_field({20, 20, 20}, 3),
      test::make_field({4, 4, 4}, [](std::int64_t i, std::int64_t j,
                                     std::int64_t k) { return static_cast<double>(i * j - k); }),
      KernelField(test::jittered_balls(4).source(), Reconstruction::kSum)};
  for (const Field& field : fields) {
    const Materials found = materials_of(field);
    EXPECT_TRUE(found.values.empty());
    EXPECT_TRUE(found.boundaries.empty());
    EXPECT_EQ(found.noisiness, 0);
  }
}

TEST(RiseSamples, HaveTheSlopeOverTheSmallestSpacing) {
  const LatticeField field =
      test::make_field({16, 16, 16}, [](std::int64_t i, std::int64_t j, std::int64_t k) {
        return static_cast<double>(i + 2 * j - 3 * k);
      });
  const auto samples = data::take_rises(field.samples());
  EXPECT_EQ(samples.size(), 16 * 16 * 16);  // faces among them, where differences are one-sided
  for (const data::RiseSample& sample : samples) {
    EXPECT_EQ(sample.gradient, Eigen::Vector3f(1, 2, -3));
    EXPECT_NEAR(sample.agreement, 1, 1e-6);
  }
}

}  // namespace joint_histogram_test
}  // namespace ovoid
