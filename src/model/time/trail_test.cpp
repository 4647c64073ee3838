// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "model/test_steps.h"
#include "ovoid/error.h"
#include "ovoid/slices.h"

namespace ovoid {
namespace trail_test {

std::vector<double> shares_of(const std::vector<StepWeight>& weights, std::size_t num_steps) {
  std::vector<double> shares(num_steps, 0.0);
  for (const StepWeight& w : weights) shares[static_cast<std::size_t>(w.step)] = w.weight;
  return shares;
}

// The trail of one step's hat function, by many samples of it.
std::vector<double> summed(const std::vector<double>& own, double first_time, double time,
                           double length, double decay) {
  constexpr int kSamples = 20000;
  std::vector<double> shares(own.size(), 0.0);
  const double from = std::max(time - length, first_time);
  double sum = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double at = from + (i + 0.5) / kSamples * (time - from);
    const double weight = std::exp(-decay * (time - at) / length);
    sum += weight;
    std::size_t a = 0;
    while (a + 2 < own.size() && own[a + 1] <= at) ++a;
    const double b = std::clamp((at - own[a]) / (own[a + 1] - own[a]), 0.0, 1.0);
    shares[a] += weight * (1 - b);
    shares[a + 1] += weight * b;
  }
  for (double& share : shares) share /= sum;
  return shares;
}

// Fails if a share is that of a step and not of what lies around it.
TEST(Trail, SharesAreIntegralsOverTime) {
  const std::vector<double> expected{0, 0, 0, 0.25, 0.5, 0.25, 0};
  const auto found = shares_of(weights_of_trail(even_times(7), 5, 2, 0), 7);
  for (std::size_t i = 0; i < 7; ++i) EXPECT_NEAR(found[i], expected[i], 1e-12) << i;
}

// Fails if uneven steps, the decay, or where the trail begins are not heeded.
TEST(Trail, SharesAreThoseOfManySamples) {
  const std::vector<double> times{0, 1, 1.5, 4, 4.25, 7};
  for (const double decay : {0.0, 1.0, 8.0, 60.0}) {
    for (const double length : {0.3, 2.0, 50.0}) {
      for (const double time : {0.4, 1.5, 5.5, 7.0}) {
        const auto found = shares_of(weights_of_trail(times, time, length, decay), times.size());
        const auto expected = summed(times, times.front(), time, length, decay);
        for (std::size_t i = 0; i < times.size(); ++i)
          EXPECT_NEAR(found[i], expected[i], 1e-3) << decay << " " << length << " " << time;
      }
    }
  }
}

TEST(Trail, HalvesHaveTheirOwnSteps) {
  const std::vector<double> times = staggered_times(9);
  for (int half = 0; half < 2; ++half) {
    std::vector<double> own;
    for (std::size_t i = static_cast<std::size_t>(half); i < times.size(); i += 2)
      own.push_back(times[i]);
    for (const double time : {0.1, 2.5, times.back()}) {
      const auto found = shares_of(weights_of_half_trail(times, half, time, 1.7, 2), times.size());
      const auto expected = summed(own, times.front(), time, 1.7, 2);
      for (std::size_t i = 0; i < own.size(); ++i)
        EXPECT_NEAR(found[2 * i + static_cast<std::size_t>(half)], expected[i], 1e-3) << time;
    }
  }
}

TEST(Trail, BeginsWithTheData) {
  EXPECT_TRUE(weights_of_trail(even_times(4), 0, 2, 1).empty());
  const auto shares = shares_of(weights_of_trail(even_times(4), 1, 100, 0), 4);
  EXPECT_NEAR(shares[0], 0.5, 1e-12);
  EXPECT_NEAR(shares[1], 0.5, 1e-12);
}

TEST(Trail, RefusesWhatIsNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [](double time, double length, double decay) {
    EXPECT_THROW(weights_of_trail(even_times(4), time, length, decay), Error)
        << time << " " << length << " " << decay;
  };
  for (const double length : {0.0, -1.0, nan, std::numeric_limits<double>::infinity()})
    refused(1, length, 0);
  for (const double decay : {-0.1, 101.0, nan}) refused(1, 1, decay);
  for (const double time : {-0.1, 3.1, nan}) refused(time, 1, 0);
}

// Fails if a trail is not on the slice's lattice, steps are exchanged between halves, or their
// weights do not add up to one.
TEST(Trail, IsTheMeanOfWhatWasThere) {
  for (const SeriesKind kind : {SeriesKind::kSteps, SeriesKind::kStaggered}) {
    const bool is_staggered = kind == SeriesKind::kStaggered;
    const auto times = is_staggered ? staggered_times(12) : even_times(9);
    // Linear in time: the mean of [2, 5] is what was there at 3.5.
    const Series series(std::make_shared<FormulaSteps>(
        kind, Index3{4, 3, 5}, times, [&times](const Vec3& position, std::int64_t step) {
          return position.x() + 10 * position.y() + 100 * position.z() +
                 1000 * times[static_cast<std::size_t>(step)];
        }));
    const Dataset trail =
        trail_before(series, 5, {.length = 3, .decay = 0, .threads = 0, .stop = {}});
    const Dataset slice = slice_at_time(series, 5);
    EXPECT_EQ(trail.lattice.kind, slice.lattice.kind);
    EXPECT_EQ(trail.lattice.dims, slice.lattice.dims);
    EXPECT_TRUE(trail.lattice.world_from_index.isApprox(slice.lattice.world_from_index));
    const std::vector<float> values = values_of(trail);
    std::size_t n = 0;
    for (std::int64_t k = 0; k < trail.lattice.dims[2]; ++k) {
      for (std::int64_t j = 0; j < trail.lattice.dims[1]; ++j) {
        for (std::int64_t i = 0; i < trail.lattice.dims[0]; ++i) {
          const Vec3 at = trail.lattice.index_position({i, j, k});
          EXPECT_NEAR(values[n++], at.x() + 10 * at.y() + 100 * at.z() + 3500, 0.01);
        }
      }
    }
    const Dataset first =
        trail_before(series, 0, {.length = 3, .decay = 0, .threads = 0, .stop = {}});
    EXPECT_EQ(values_of(first), values_of(slice_at_time(series, 0)));
  }
}

}  // namespace trail_test
}  // namespace ovoid
