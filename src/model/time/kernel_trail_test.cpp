// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "model/test_datasets.h"
#include "model/test_steps.h"
#include "model/time/trail_moments.h"
#include "ovoid/error.h"
#include "ovoid/slices.h"

namespace ovoid::model {
namespace kernel_trail_test {

double sum_of_shares(const std::vector<TimeShare>& moments) {
  double sum = 0;
  for (const TimeShare& moment : moments) sum += moment.share;
  return sum;
}

// Fails if a moment has another share than the integral over its part, or is not at the centroid.
TEST(TrailMoments, HaveTheSharesOfTheirTimes) {
  for (const double decay : {0.0, 1e-7, 2.0, 30.0}) {
    const TrailWeight weight{5, 3, decay};
    double sum = 0, first_moment = 0;
    constexpr int kMany = 200000;
    for (int i = 0; i < kMany; ++i) {
      const double time = 2.5 + (i + 0.5) / kMany;
      const double share = std::exp(-decay * (5 - time) / 3) / kMany;
      sum += share;
      first_moment += share * time;
    }
    EXPECT_NEAR(weight.integral(2.5, 3.5), sum, 1e-9 * sum) << decay;
    EXPECT_NEAR(weight.centroid(2.5, 3.5), first_moment / sum, 1e-9) << decay;
  }
}

TEST(TrailMoments, AddUpToOneInOrder) {
  const std::vector<TrailPart> parts = {
      {0.5, 1, 0, 1, true, 3.2}, {1, 3, 1, 3, false}, {3, 4, 3, 4, false}, {4, 4.5, 4, 5, true, 1}};
  for (const double decay : {0.0, 2.0}) {
    for (const int most : {100, 4, 1}) {
      const auto moments = moments_of(parts, {4.5, 4, decay}, most);
      EXPECT_NEAR(sum_of_shares(moments), 1, 1e-12);
      EXPECT_EQ(moments.size(), static_cast<std::size_t>(std::min(most, 8)));
      for (std::size_t i = 1; i < moments.size(); ++i)
        EXPECT_LT(moments[i - 1].time, moments[i].time);
    }
  }
  // Four cuts of the first part, then the steps 1, 3 and 4, each with half of the times beside it.
  const auto moments = moments_of(parts, {4.5, 4, 0}, 100);
  EXPECT_NEAR(moments[0].share, 0.125 / 4, 1e-12);
  EXPECT_NEAR(moments[0].time, 0.5625, 1e-12);
  EXPECT_NEAR(moments[5].share, 1.5 / 4, 1e-12);
  EXPECT_EQ(moments[5].time, 3);
}

// Fails if moments that nobody would see are drawn.
TEST(TrailMoments, LeaveOutWhatIsNotSeen) {
  const auto moments = moments_of({{0, 1, 0, 1, true, 100}}, {1, 1, 100}, 200);
  EXPECT_LT(moments.size(), 15U);
  EXPECT_GT(moments.front().time, 0.85);
}

Dataset particles(const std::vector<Vec3>& places, std::vector<float> values, bool has_numbers) {
  Dataset dataset = points_dataset(DatasetKind::kParticles, places, std::move(values));
  dataset.arrays.push_back(
      array_of_numbers("h", 1, std::vector<float>(places.size(), 2.0F)));  // sigma 1
  if (!has_numbers) return dataset;
  std::vector<float> numbers;
  for (std::size_t i = 0; i < places.size(); ++i) numbers.push_back(static_cast<float>(i));
  dataset.arrays.push_back(array_of_numbers("id", 1, std::move(numbers)));
  return dataset;
}

Series given(std::vector<Dataset> steps, std::vector<double> times) {
  return Series(std::make_shared<GivenSteps>(std::move(steps), std::move(times)));
}

KernelModelOptions density() {
  KernelModelOptions options;
  options.is_density = true;
  return options;
}

KernelTrail trail_of(const Series& series, double time, const TrailOptions& options,
                     const KernelModelOptions& model) {
  return kernel_trail_before(series, time, options, model,
                             make_kernel_field(slice_at_time(series, time), model));
}

// One particle goes along x at constant speed: its trail is the integral of its kernel.
TEST(KernelTrail, OfOneParticleIsTheIntegral) {
  const Series series =
      given({particles({{0, 0, 0}}, {1}, true), particles({{40, 0, 0}}, {1}, true)}, {0, 4});
  const KernelField still = make_kernel_field(*series.step(0), density());
  const KernelSampler kernel(still);
  for (const double decay : {0.0, 3.0}) {
    const KernelTrail trail =
        trail_of(series, 3, {.length = 2, .decay = decay, .threads = 1, .stop = {}}, density());
    ASSERT_EQ(trail.moments.size(), 1U);  // a sum
    EXPECT_EQ(trail.moments[0].field.num_kernels(), 20);
    EXPECT_TRUE(trail.notes.empty());
    const KernelSampler sampler(trail.moments[0].field);
    double greatest = 0;
    std::vector<std::pair<double, double>> along;  // place, error
    for (double x = 5; x <= 35; x += 0.37) {
      const Vec3 at(x, 0.4, -0.3);
      double integral = 0, sum = 0;
      constexpr int kMany = 4000;
      for (int i = 0; i < kMany; ++i) {
        const double time = 1 + 2 * (i + 0.5) / kMany;
        const double weight = std::exp(-decay * (3 - time) / 2);
        integral += weight * kernel.at(at - Vec3(10 * time, 0, 0)).value;
        sum += weight;
      }
      along.emplace_back(x, sampler.at(at).value - integral / sum);
      greatest = std::max(greatest, integral / sum);
    }
    EXPECT_GT(greatest, 0.005);
    const double bound = decay > 0 ? 1e-3 : 1e-4;
    for (const auto& [x, error] : along) {
      const bool is_end = std::abs(x - 10) < 5 || std::abs(x - 30) < 5;
      EXPECT_NEAR(error, 0, (is_end ? 0.02 : bound) * greatest) << x << ", decay " << decay;
    }
  }
}

TEST(KernelTrail, OfWhatStandsStillIsTheField) {
  const std::vector<Vec3> places = {{0, 0, 0}, {1, 0.5, 0}, {0, 2, 1}};
  const Dataset step = particles(places, {1, 2, 3}, true);
  const Series series = given({step, step, step}, {0, 1, 5});
  const KernelField field = make_kernel_field(step, density());
  const KernelTrail trail =
      trail_of(series, 4, {.length = 3.5, .decay = 1, .threads = 1, .stop = {}}, density());
  ASSERT_EQ(trail.moments.size(), 1U);
  const KernelSampler before(field), mean(trail.moments[0].field);
  for (double x = -3; x < 4; x += 0.7) {
    const Vec3 at(x, 0.3, 0.2);
    EXPECT_NEAR(mean.at(at).value, before.at(at).value, 1e-6 * field.value_range().hi);
  }
}

KernelModelOptions values_of_array() {
  KernelModelOptions options;
  options.array = "v";
  options.reconstruction = Reconstruction::kNormalized;
  return options;
}

// Fails if particles are mixed up, do not go straight, or moments have other times than they stand
// for.
TEST(KernelTrail, ParticlesWithNumbersGoStraight) {
  const std::vector<Vec3> from = {{0, 0, 0}, {10, 0, 0}, {0, 30, 0}};
  const std::vector<Vec3> to = {{4, 0, 0}, {10, 4, 0}, {0, 30, 4}};
  const Series series =
      given({particles(from, {1, 2, 3}, true), particles(to, {5, 2, 3}, true)}, {0, 1});
  const KernelTrail trail =
      trail_of(series, 1, {.length = 0.5, .decay = 0, .threads = 1, .stop = {}}, values_of_array());
  ASSERT_EQ(trail.moments.size(), 2U);  // two sigmas are gone
  for (std::size_t m = 0; m < 2; ++m) {
    EXPECT_DOUBLE_EQ(trail.moments[m].share, 0.5);
    const double time = m == 0 ? 0.625 : 0.875;
    const auto kernels = kernels_of(trail.moments[m].field);
    ASSERT_EQ(kernels.size(), 3U);
    EXPECT_NEAR((kernels[0].center - Vec3(0, 30, 4 * time)).norm(), 0, 1e-5);
    EXPECT_NEAR((kernels[1].center - Vec3(4 * time, 0, 0)).norm(), 0, 1e-5);
    EXPECT_NEAR((kernels[2].center - Vec3(10, 4 * time, 0)).norm(), 0, 1e-5);
    EXPECT_NEAR(static_cast<double>(kernels[1].values[0]), 1 + 4 * time, 1e-5);
  }
}

TEST(KernelTrail, OthersStandAtTheirSteps) {
  const Series series =
      given({particles({{0, 0, 0}}, {1}, false), particles({{9, 0, 0}}, {1}, false),
             particles({{18, 0, 0}}, {1}, false)},
            {0, 1, 2});
  const KernelTrail trail = trail_of(
      series, 2, {.length = 1.25, .decay = 0, .threads = 1, .stop = {}}, values_of_array());
  ASSERT_EQ(trail.moments.size(), 2U);  // of the first half none is in the trail
  EXPECT_NEAR(trail.moments[0].share, 0.75 / 1.25, 1e-12);
  EXPECT_NEAR(kernels_of(trail.moments[0].field)[0].center.x(), 9, 1e-6);
  EXPECT_NEAR(kernels_of(trail.moments[1].field)[0].center.x(), 18, 1e-6);
  ASSERT_EQ(trail.notes.size(), 1U);
  EXPECT_NE(trail.notes[0].find("no numbers"), std::string::npos) << trail.notes[0];
}

// What the renderer makes of moments at a place: docs/numerics.md, "With a trail of kernel sets".
struct MeanAtPlace {
  double value = 0, presence = 0;

  void add(const KernelSample& sample, double share) {
    if (!sample.is_defined) return;
    value += share * sample.value;
    presence += share;
  }
};

// A mesh that goes and turns, with values that change: the moments' mean against that of very many
// times.
TEST(KernelTrail, OfAMeshIsTheMeanOverTime) {
  const auto mesh = [](double angle, double x, float more) {
    Dataset dataset = grid_dataset({6, 4, 4}, [&](const Vec3& at) {
      return Vec3(Eigen::AngleAxisd(angle, Vec3::UnitZ()) * at + Vec3(x, 0, 0));
    });
    std::vector<float> values;
    for (std::int64_t i = 0; i < dataset.num_positions(); ++i)
      values.push_back(static_cast<float>(i % 6) + more);
    dataset.arrays = {array_of_numbers("v", 1, std::move(values))};
    return dataset;
  };
  const Series series = given({mesh(0, 0, 0), mesh(0.3, 2, 1), mesh(0.3, 6, 1)}, {0, 1, 2});
  const KernelModelOptions model = values_of_array();
  const TrailOptions options{.length = 1.5, .decay = 1, .threads = 1, .stop = {}};
  const KernelTrail trail = trail_of(series, 2, options, model);
  EXPECT_GT(trail.moments.size(), 8U);
  EXPECT_LT(trail.moments.size(), 20U);
  std::vector<Vec3> places;
  for (int i = 0; i < 60; ++i) places.push_back({-0.5 + 0.2 * i, 1.1 + 0.03 * i, 1.5 + 0.01 * i});
  std::vector<MeanAtPlace> expected(places.size()), found(places.size());
  constexpr int kTimes = 300;
  double sum = 0;
  for (int t = 0; t < kTimes; ++t) {
    const double time = 0.5 + 1.5 * (t + 0.5) / kTimes;
    const double weight = std::exp(-(2 - time) / 1.5);
    const KernelSampler sampler(make_kernel_field(slice_at_time(series, time), model));
    for (std::size_t i = 0; i < places.size(); ++i) expected[i].add(sampler.at(places[i]), weight);
    sum += weight;
  }
  for (const KernelMoment& moment : trail.moments) {
    const KernelSampler sampler(moment.field);
    for (std::size_t i = 0; i < places.size(); ++i)
      found[i].add(sampler.at(places[i]), moment.share);
  }
  double worst_value = 0, mean_presence = 0;
  int num_partly = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double presence = expected[i].presence / sum;
    // A moment comes and goes as a whole: no share is off by more than the largest one.
    EXPECT_NEAR(found[i].presence, presence, 0.15) << i;
    mean_presence += (found[i].presence - presence) / static_cast<double>(places.size());
    num_partly += presence > 0.1 && presence < 0.9 ? 1 : 0;
    if (presence < 0.3) continue;
    worst_value = std::max(worst_value, std::abs(found[i].value / found[i].presence -
                                                 expected[i].value / expected[i].presence));
  }
  EXPECT_GT(num_partly, 20);
  EXPECT_NEAR(mean_presence, 0, 0.02);
  EXPECT_LT(worst_value, 0.5);  // of 6
}

// Fails if values that change are those of a step, or what does not move is not all there.
TEST(KernelTrail, OfAMeshThatStandsStillHasTheMeanOfItsValues) {
  Dataset first = grid_dataset({4, 4, 4}, [](const Vec3& at) { return at; });
  Dataset last = first;
  std::vector<float> values = values_of(first);
  for (float& value : values) value = 3 * value + 1;
  last.arrays = {array_of_numbers("v", 1, std::move(values))};
  const Series series = given({first, last}, {0, 1});
  const KernelModelOptions model = values_of_array();
  const KernelTrail trail =
      trail_of(series, 0.75, {.length = 0.5, .decay = 0, .threads = 1, .stop = {}}, model);
  ASSERT_EQ(trail.moments.size(), 1U);
  EXPECT_EQ(trail.moments[0].share, 1);
  const KernelSampler mean(trail.moments[0].field);
  const KernelSampler start(make_kernel_field(first, model));
  for (const Vec3& at : {Vec3(0.2, 0.7, 1.1), Vec3(1.5, 1.5, 1.5), Vec3(2.9, 0.1, 2)})
    EXPECT_NEAR(mean.at(at).value, 0.5 * (start.at(at).value + 3 * start.at(at).value + 1), 1e-4);
}

TEST(KernelTrail, KeepsToItsLimits) {
  const Series series =
      given({particles({{0, 0, 0}}, {1}, true), particles({{500, 0, 0}}, {1}, true)}, {0, 1});
  TrailOptions options{.length = 1, .decay = 0, .threads = 1, .stop = {}};
  const auto count = [&] { return trail_of(series, 1, options, values_of_array()).moments.size(); };
  EXPECT_EQ(count(), 64U);
  options.most_moments = 7;
  const KernelTrail few = trail_of(series, 1, options, values_of_array());
  EXPECT_EQ(few.moments.size(), 7U);
  ASSERT_EQ(few.notes.size(), 1U);
  EXPECT_NE(few.notes[0].find("71.4 sigmas"), std::string::npos) << few.notes[0];
  options.memory_limit = 1;
  EXPECT_EQ(count(), 1U);
  options.most_moments = 0;
  EXPECT_THROW(count(), Error);
}

TEST(KernelTrail, BeginsWithTheDataAndRefusesWhatIsNone) {
  const Series series =
      given({particles({{0, 0, 0}}, {1}, true), particles({{5, 0, 0}}, {1}, true)}, {0, 1});
  const auto at = [&](double time, double length, double decay) {
    return trail_of(series, time, {.length = length, .decay = decay, .threads = 1, .stop = {}},
                    values_of_array());
  };
  const KernelTrail first = at(0, 1, 0);
  ASSERT_EQ(first.moments.size(), 1U);
  EXPECT_EQ(kernels_of(first.moments[0].field)[0].center.x(), 0);
  EXPECT_EQ(at(1, 100, 0).moments.size(), 5U);
  EXPECT_THROW(at(1, 0, 0), Error);
  EXPECT_THROW(at(1, 1, -1), Error);
  EXPECT_THROW(at(1.5, 1, 0), Error);
}

}  // namespace kernel_trail_test
}  // namespace ovoid::model
