// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "model/test_steps.h"
#include "ovoid/error.h"
#include "ovoid/model.h"
#include "ovoid/resample.h"
#include "ovoid/slices.h"

namespace ovoid {
namespace time_slice_test {

constexpr Index3 kDims{4, 3, 5};

// Steps of numbers by formula: the value of sample i of step s.
using NumberFormula = double (*)(std::int64_t step, std::int64_t sample);

Series series_of_numbers(SeriesKind kind, std::vector<double> times, NumberFormula value) {
  return Series(std::make_shared<FormulaSteps>(
      kind, kDims, std::move(times), [value](const Vec3& position, std::int64_t step) {
        Index3 at;
        for (std::size_t a = 0; a < 3; ++a)
          at[a] = static_cast<std::int64_t>(std::floor(position[static_cast<int>(a)]));
        return value(step, at[0] + kDims[0] * (at[1] + kDims[1] * at[2]));
      }));
}

double weight_at(const std::vector<StepWeight>& weights, std::int64_t step) {
  for (const StepWeight& w : weights) {
    if (w.step == step) return w.weight;
  }
  return 0;
}

// Fails if uneven times are taken for even ones, or the ends are shut out.
TEST(TimeSlice, StepsAreLinearInRealTime) {
  const std::vector<double> times{0, 1, 5};
  EXPECT_EQ(weights_of_steps(times, 0).size(), 1U);
  EXPECT_EQ(weights_of_steps(times, 5).front().step, 2);
  EXPECT_NEAR(weight_at(weights_of_steps(times, 2), 1), 0.75, 1e-12);
  EXPECT_NEAR(weight_at(weights_of_steps(times, 2), 2), 0.25, 1e-12);
  for (const double wrong : {-0.1, 5.1, std::nan("")})
    EXPECT_THROW(weights_of_steps(times, wrong), Error) << wrong;
}

// Fails if a half's own spacing, shift or kernel is another: the published weights.
TEST(TimeSlice, GaussianWeightsAreThePublishedOnes) {
  const std::vector<double> times = staggered_times(9);
  // The time of the middle step of the even half, and a quarter and a half of T behind it.
  const double middle = times[4];
  const auto expect = [&](double time, int half, const std::vector<double>& expected) {
    const auto weights = weights_of_half(times, half, middle + time, TimeFilter::kGaussian);
    const std::int64_t first = half == 0 ? 2 : 1;
    for (std::size_t k = 0; k < expected.size(); ++k)
      EXPECT_NEAR(weight_at(weights, first + 2 * static_cast<std::int64_t>(k)), expected[k], 6e-4)
          << time << ", half " << half << ", tap " << k;
  };
  expect(0, 0, {0.0177, 0.9647, 0.0177});
  expect(0, 1, {0, 0.4998, 0.4998, 0});
  expect(0.25, 0, {0.0041, 0.9261, 0.0698});
  expect(0.25, 1, {0, 0.1954, 0.8035});
  expect(0.5, 0, {0.0008, 0.7628, 0.2364});
  expect(0.5, 1, {0, 0.0555, 0.9392});
}

// Fails if something jumps as time goes on, or a static volume flickers.
TEST(TimeSlice, WeightsAreContinuousAndAddUpToOne) {
  const std::vector<double> times = staggered_times(12);
  for (const TimeFilter filter : {TimeFilter::kFourSteps, TimeFilter::kTwoSteps}) {
    for (int half = 0; half < 2; ++half) {
      std::vector<double> before(times.size(), 0.0);
      for (double time = times.front(); time <= times.back(); time += 1e-3) {
        std::vector<double> now(times.size(), 0.0);
        double sum = 0;
        const auto weights = weights_of_half(times, half, time, filter);
        EXPECT_LE(weights.size(), filter == TimeFilter::kTwoSteps ? 2U : 4U);
        for (const StepWeight& w : weights) {
          now[static_cast<std::size_t>(w.step)] = w.weight;
          sum += w.weight;
        }
        EXPECT_NEAR(sum, 1, 1e-12);
        for (std::size_t s = 0; time > times.front() && s < now.size(); ++s)
          EXPECT_NEAR(now[s], before[s], 0.01) << time;
        before = now;
      }
    }
  }
}

// Uneven in time, and where one half has no step on one side. Fails if the cubic's slopes are
// those of other steps, or a half stands still where the other one goes on.
TEST(TimeSlice, FourStepsFollowAStraightLineToTheEndsOfTime) {
  std::vector<double> times = staggered_times(9);
  times[0] -= 0.3;
  for (int half = 0; half < 2; ++half) {
    for (double time = times.front(); time <= times.back(); time += 0.07) {
      double value = 0;
      for (const StepWeight& w : weights_of_half(times, half, time, TimeFilter::kFourSteps))
        value += w.weight * static_cast<double>(w.step);
      // In the half's own numbers, on which its steps are even.
      double place = half;
      for (std::size_t l = static_cast<std::size_t>(half); l + 2 < times.size(); l += 2) {
        if (l > static_cast<std::size_t>(half) && time < times[l]) break;
        place = static_cast<double>(l) + 2 * (time - times[l]) / (times[l + 2] - times[l]);
      }
      EXPECT_NEAR(value, place, 1e-9) << time << ", half " << half;
    }
  }
}

// Fails if a filter does not divide by what it sums, at faces and at the ends of time, too.
TEST(TimeSlice, StaticVolumesStay) {
  const Series series = series_of_numbers(SeriesKind::kStaggered, staggered_times(8),
                                          [](std::int64_t, std::int64_t) { return 3.0; });
  for (const TimeFilter filter :
       {TimeFilter::kFourSteps, TimeFilter::kTwoSteps, TimeFilter::kGaussian, TimeFilter::kExact}) {
    for (const double time : {0.0, 0.3, 1.7, 3.1, series.times().back()}) {
      TimeSliceOptions options;
      options.filter = filter;
      const Dataset slice = slice_at_time(series, time, options);
      EXPECT_EQ(slice.lattice.kind, LatticeKind::kBodyCentred);
      EXPECT_EQ(slice.lattice.dims, (Index3{4, 3, 10}));
      for (const float value : values_of(slice)) EXPECT_NEAR(value, 3.0F, 1e-5F);
    }
  }
}

// Each half has samples of its own, which do not change. Not by `exact`, which mixes the halves by
// the time.
TEST(TimeSlice, StaticVolumesStayWhateverTheyHold) {
  const Series series = series_of_numbers(
      SeriesKind::kStaggered, staggered_times(9), [](std::int64_t step, std::int64_t sample) {
        return 2 + std::sin(0.3 * static_cast<double>(sample + step % 2));
      });
  const auto values_at = [&](TimeFilter filter, double time) {
    TimeSliceOptions options;
    options.filter = filter;
    return values_of(slice_at_time(series, time, options));
  };
  for (const TimeFilter filter :
       {TimeFilter::kFourSteps, TimeFilter::kTwoSteps, TimeFilter::kGaussian}) {
    const std::vector<float> first = values_at(filter, series.times()[3]);
    for (const double share : {0.2, 0.5, 0.9}) {
      const double time = series.times()[3] + share * (series.times()[4] - series.times()[3]);
      const std::vector<float> values = values_at(filter, time);
      for (std::size_t i = 0; i < values.size(); ++i) EXPECT_NEAR(values[i], first[i], 1e-5F) << i;
    }
  }
}

// Of a wave that moves, how far slices are from it, root of the mean square over all times; and how
// far what every sample has more than the other half's around it is from what the wave has there.
struct WaveErrors {
  double value = 0, alternation = 0;
};

WaveErrors errors_of_wave(TimeFilter filter) {
  const Index3 dims{10, 9, 11};
  const std::vector<double> times = staggered_times(14);
  const auto wave = [](const Vec3& p, double t) {
    return std::cos(0.5 * p.x() - 0.4 * p.y() + 0.3 * p.z() - 1.2 * t);
  };
  const Series series(std::make_shared<FormulaSteps>(
      SeriesKind::kStaggered, dims, times, [&](const Vec3& position, std::int64_t step) {
        return wave(position, times[static_cast<std::size_t>(step)]);
      }));
  WaveErrors sums;
  int count = 0;
  for (double time = times.front(); time <= times.back(); time += 0.17) {
    TimeSliceOptions options;
    options.filter = filter;
    const Dataset slice = slice_at_time(series, time, options);
    const std::vector<float> values = values_of(slice);
    const auto error_at = [&](const Index3& at) {
      const Vec3 position = slice.lattice.world_from_index * slice.lattice.index_position(at);
      const auto i = static_cast<std::size_t>(at[0] + slice.lattice.dims[0] *
                                                          (at[1] + slice.lattice.dims[1] * at[2]));
      return static_cast<double>(values[i]) - wave(position, time);
    };
    for (std::int64_t z = 2; z < 2 * dims[2] - 2; ++z) {
      for (std::int64_t y = 1; y < dims[1] - 1; ++y) {
        for (std::int64_t x = 1; x < dims[0] - 1; ++x, ++count) {
          const double own = error_at({x, y, z});
          double around = 0;
          const std::int64_t shift = z % 2 == 0 ? -1 : 0;
          for (int n = 0; n < 8; ++n)
            around += error_at({x + shift + n % 2, y + shift + n / 2 % 2, n < 4 ? z - 1 : z + 1});
          sums.value += own * own;
          sums.alternation += std::pow(own - around / 8, 2);
        }
      }
    }
  }
  return {std::sqrt(sums.value / count), std::sqrt(sums.alternation / count)};
}

// A checkerboard on whatever moves is what an isosurface shows first. Fails if halves are not
// evened out, or what is evened out is the data's own.
TEST(TimeSlice, FourStepsAreNearerToWhatMovesAndEven) {
  const WaveErrors four = errors_of_wave(TimeFilter::kFourSteps);
  const WaveErrors two = errors_of_wave(TimeFilter::kTwoSteps);
  std::printf("[wave      ] four steps %.4f, alternating %.4f; two steps %.4f, %.4f\n", four.value,
              four.alternation, two.value, two.alternation);
  EXPECT_LT(four.value, 0.5 * two.value);
  EXPECT_LT(four.alternation, 0.25 * two.alternation);
}

// Fails if what is missing at a sample is missing around it, or a sample at its own time waits for
// those of other times.
TEST(TimeSlice, MissingSamplesAreNoOthers) {
  const Series series = series_of_numbers(
      SeriesKind::kStaggered, staggered_times(9), [](std::int64_t step, std::int64_t sample) {
        return step == 4 && sample == 25 ? std::numeric_limits<double>::quiet_NaN()
                                         : static_cast<double>(sample + 3 * step);
      });
  const auto missing_at = [&](double time) {
    int missing = 0;
    for (const float value : values_of(slice_at_time(series, time))) missing += std::isnan(value);
    return missing;
  };
  EXPECT_EQ(missing_at(series.times()[4]), 1);
  EXPECT_EQ(missing_at(series.times()[4] + 0.3), 1);
  EXPECT_EQ(missing_at(series.times()[6]), 0);
}

// Fails if halves are exchanged, or layers are not theirs in turn.
TEST(TimeSlice, HalvesBecomeLayersInTurn) {
  const Series series = series_of_numbers(
      SeriesKind::kStaggered, staggered_times(6),
      [](std::int64_t step, std::int64_t sample) { return step % 2 * 1000.0 + sample; });
  const std::vector<float> values = values_of(slice_at_time(series, 1.0));
  for (std::int64_t layer = 0; layer < 10; ++layer) {
    for (std::int64_t i = 0; i < 12; ++i) {
      EXPECT_NEAR(values[static_cast<std::size_t>(layer * 12 + i)],
                  static_cast<float>(layer % 2 * 1000 + layer / 2 * 12 + i), 1e-3F);
    }
  }
}

// Fails if the sum is not that over all samples of the four-dimensional lattice in reach.
TEST(TimeSlice, ExactIsTheSumOverTheWholeLattice) {
  const NumberFormula value = [](std::int64_t step, std::int64_t sample) {
    return std::sin(1.3 * static_cast<double>(step) + 0.7 * static_cast<double>(sample));
  };
  const std::vector<double> times = staggered_times(9);
  const Series series = series_of_numbers(SeriesKind::kStaggered, times, value);
  TimeSliceOptions options;
  options.filter = TimeFilter::kExact;
  const double time = times[4] + 0.3;
  const Dataset slice = slice_at_time(series, time, options);
  const std::vector<float> values = values_of(slice);
  const double unit = std::numbers::sqrt2;  // of an axis vector, T
  for (const Index3& at : {Index3{1, 1, 4}, Index3{2, 1, 5}, Index3{0, 0, 0}, Index3{3, 2, 9}}) {
    const Vec3 place = slice.lattice.index_position(at);
    double sum = 0;
    double weights = 0;
    for (std::int64_t s = 0; s < 9; ++s) {
      const Vec3 shift = Vec3::Constant(s % 2 == 1 ? 0.5 : 0.0);
      std::int64_t sample = 0;
      for (std::int64_t k = 0; k < 5; ++k) {
        for (std::int64_t j = 0; j < 3; ++j) {
          for (std::int64_t i = 0; i < 4; ++i, ++sample) {
            const Vec3 other(static_cast<double>(i), static_cast<double>(j),
                             static_cast<double>(k));
            const Vec3 d = unit * (other + shift - place);
            const double dt = times[static_cast<std::size_t>(s)] - time;
            if (std::abs(dt) > 2 || d.cwiseAbs().maxCoeff() > 2 - 1e-9) continue;
            const double w = std::exp(-2 * (d.squaredNorm() + dt * dt));
            sum += w * value(s, sample);
            weights += w;
          }
        }
      }
    }
    const auto position = static_cast<std::size_t>(at[0] + 4 * (at[1] + 3 * at[2]));
    EXPECT_NEAR(values[position], sum / weights, 1e-5) << at[0] << " " << at[1] << " " << at[2];
  }
}

// Fails if a formula sampled on both lattices is not the same thing in time.
TEST(TimeSlice, StaggeredSamplesShowWhatCartesianOnesShow) {
  MakeOptions options;
  options.size = {24, 24, 24};
  const auto steps = make_sample_steps("tornado", 17, SeriesKind::kSteps, options);
  const auto halves = make_sample_steps("tornado", 17, SeriesKind::kStaggered, options);
  EXPECT_EQ(halves->num_steps(), 23);
  EXPECT_EQ(halves->read(3).lattice.dims, (Index3{17, 17, 17}));
  const Series series(halves);
  const double time = 7.4;
  const Dataset slice = slice_at_time(series, time);
  MakeOptions exact = options;
  exact.lattice = LatticeKind::kBodyCentred;
  exact.time = time / 16;
  const Dataset formula = make_sample("tornado", exact);
  const std::vector<float> expected = values_of(formula);
  const std::vector<float> found = values_of(slice);
  double square = 0;
  for (std::size_t i = 0; i < expected.size(); ++i)
    square += std::pow(static_cast<double>(found[i]) - static_cast<double>(expected[i]), 2);
  EXPECT_LT(std::sqrt(square / static_cast<double>(expected.size())), 0.04);
}

// Fails if resampling in time mistakes steps for times, or the halves' shift.
TEST(ResampleSeries, BringsStepsToBothLattices) {
  MakeOptions options;
  options.size = {20, 20, 20};
  const Series series(make_sample_steps("tornado", 24, SeriesKind::kSteps, options));
  SeriesResampleOptions how;
  how.lattice.band_limit = false;
  const auto halves = resample_series(series, SeriesKind::kStaggered, how);
  const auto formula = make_sample_steps("tornado", 24, SeriesKind::kStaggered, options);
  ASSERT_EQ(halves->num_steps(), formula->num_steps());
  ASSERT_EQ(halves->times(), formula->times());
  for (const std::int64_t step : {0, 7, 20}) {
    const Dataset found = halves->read(step);
    const Dataset expected = formula->read(step);
    ASSERT_TRUE(found.lattice.world_from_index.isApprox(expected.lattice.world_from_index, 1e-9));
    ASSERT_EQ(found.lattice.dims, expected.lattice.dims);
    const std::vector<float> a = values_of(found);
    const std::vector<float> b = values_of(expected);
    double square = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
      square += std::pow(static_cast<double>(a[i]) - static_cast<double>(b[i]), 2);
    EXPECT_LT(std::sqrt(square / static_cast<double>(a.size())), 0.04) << step;
  }
  how.memory_limit = 1000;
  EXPECT_THROW(resample_series(series, SeriesKind::kStaggered, how), Error);
  const Series uneven = series_of_numbers(SeriesKind::kSteps, {0, 1, 3},
                                          [](std::int64_t, std::int64_t) { return 1.0; });
  EXPECT_THROW(resample_series(uneven, SeriesKind::kStaggered), Error);
}

}  // namespace time_slice_test
}  // namespace ovoid
