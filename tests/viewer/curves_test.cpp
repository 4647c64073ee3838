// SPDX-License-Identifier: Apache-2.0
// Where values lie in the curve editor, and how often they occur.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "curve_editor.h"
#include "histogram.h"
#include "ovoid/error.h"
#include "ovoid/kernel_field.h"
#include "support/kernel_sets.h"
#include "support/volumes.h"

namespace ovoid::viewer {
namespace curves_test {

using cli::Histogram;
using cli::histogram_of;
using cli::kHistogramBins;

std::uint64_t sum_of(const Histogram::Bins& bins) {
  return std::accumulate(bins.counts.begin(), bins.counts.end(), std::uint64_t{0});
}
std::uint64_t sum_of(const Histogram& histogram) { return sum_of(histogram.linear); }

std::uint64_t count_at(const Histogram::Bins& bins, double value) {
  const double place = (value - bins.lo) / (bins.hi - bins.lo);
  const double bin = std::floor(place * static_cast<double>(bins.counts.size()));
  return bins.counts.at(std::min(static_cast<std::size_t>(bin), bins.counts.size() - 1));
}
std::uint64_t count_at(const Histogram& histogram, double value) {
  return count_at(histogram.linear, value);
}

TEST(ValueAxes, ThereAndBack) {
  for (const ValueAxis& axis :
       {ValueAxis{-3, 5}, ValueAxis{1e-3, 1e4, ValueScale::kLog},
        ValueAxis{-1000, 1e5, ValueScale::kSymlog, 0.5}, ValueAxis{1e30, 3e30}}) {
    EXPECT_NEAR(axis.place_of(axis.lo), 0, 1e-12);
    EXPECT_NEAR(axis.place_of(axis.hi), 1, 1e-12);
    double last = -HUGE_VAL;
    for (int i = -10; i <= 110; ++i) {  // beyond both ends, too
      const double place = i / 100.0;
      const double value = axis.value_at(place);
      EXPECT_GT(value, last);
      last = value;
      // A logarithm of about ten decades loses some units in the last place.
      EXPECT_NEAR(axis.place_of(value), place, 1e-10);
    }
  }
}

TEST(ValueAxes, TheirMiddles) {
  EXPECT_DOUBLE_EQ((ValueAxis{-3, 5}).value_at(0.5), 1);
  EXPECT_NEAR((ValueAxis{1e-2, 1e4, ValueScale::kLog}).value_at(0.5), 10, 1e-12);
  const ValueAxis symlog{-100, 100, ValueScale::kSymlog, 2};
  EXPECT_NEAR(symlog.value_at(0.5), 0, 1e-12);
  EXPECT_NEAR(symlog.value_at(0.75), -symlog.value_at(0.25), 1e-12);
  // log10(1 + |v| / w) is half of what it is at the end.
  EXPECT_NEAR(symlog.value_at(0.75), 2 * (std::sqrt(51.0) - 1), 1e-12);
  // What has no logarithm lies far below, and is a number.
  EXPECT_LT((ValueAxis{1, 10, ValueScale::kLog}).place_of(-5), -100);
}

TEST(Histograms, OfALatticeCountEachSampleOnce) {
  const LatticeField field = test::make_field(
      {10, 9, 8}, [](auto i, auto, auto) { return static_cast<double>(i % 4); }, {});
  const Histogram histogram = histogram_of(field);
  EXPECT_EQ(histogram.linear.lo, 0);
  EXPECT_EQ(histogram.linear.hi, 3);
  ASSERT_EQ(histogram.linear.counts.size(), static_cast<std::size_t>(kHistogramBins));
  EXPECT_EQ(sum_of(histogram), 720U);
  EXPECT_EQ(count_at(histogram, 0), 3U * 72);  // i = 0, 4, 8
  EXPECT_EQ(count_at(histogram, 1), 3U * 72);
  EXPECT_EQ(count_at(histogram, 2), 2U * 72);
  EXPECT_EQ(count_at(histogram, 3), 2U * 72);  // the last bin has its upper end
  EXPECT_EQ(histogram.linear.greatest, 3U * 72);
}

// Those without a logarithm are left out.
TEST(Histograms, ByDecades) {
  const double values[] = {-3, 0, 1, 10, 100, 1000};
  const LatticeField field =
      test::make_field({6, 4, 4}, [&](auto i, auto, auto) { return values[i]; }, {});
  const Histogram histogram = histogram_of(field);
  EXPECT_EQ(sum_of(histogram.linear), 96U);
  EXPECT_EQ(sum_of(histogram.logarithmic), 64U);
  EXPECT_NEAR(histogram.logarithmic.hi, 3, 1e-6);
  EXPECT_NEAR(histogram.logarithmic.lo, -3, 1e-6);  // six decades
  EXPECT_EQ(histogram.logarithmic.greatest, 16U);
}

TEST(Histograms, OfScaledNumbersMissingSamplesAndOneValue) {
  test::FieldSetup setup;
  setup.value_scale = 0.5;
  setup.value_offset = 100;
  const LatticeField scaled = test::make_field(
      {4, 4, 4},
      [](auto i, auto j, auto) { return i == 0 ? test::kMissing : static_cast<double>(j); }, setup);
  const Histogram histogram = histogram_of(scaled);
  EXPECT_EQ(histogram.linear.lo, 100);
  EXPECT_EQ(histogram.linear.hi, 101.5);
  EXPECT_EQ(sum_of(histogram), 48U);
  EXPECT_EQ(count_at(histogram, 100.5), 12U);
  const Histogram flat = histogram_of(test::constant_field({4, 4, 4}, 7));
  EXPECT_EQ(sum_of(flat), 64U);
  EXPECT_EQ(count_at(flat, 7), 64U);
}

// Its two sublattices lie one after the other along z, so that a brick is twice as deep.
TEST(Histograms, OfABodyCentredLattice) {
  test::FieldSetup setup;
  setup.lattice = LatticeKind::kBodyCentred;
  const LatticeField field = test::make_field(
      {9, 10, 20}, [](auto, auto, auto k) { return static_cast<double>(k % 2); }, setup);
  const Histogram histogram = histogram_of(field);
  EXPECT_EQ(sum_of(histogram), static_cast<std::uint64_t>(field.num_kernels()));
  EXPECT_EQ(count_at(histogram, 0), 900U);
  EXPECT_EQ(count_at(histogram, 1), 900U);
}

test::KernelNumbers balls_apart(int count) {
  test::KernelNumbers set;
  set.shape = KernelShape::kBalls;
  for (int i = 0; i < count; ++i) {
    set.add(Vec3(10 * i, 0, 0), Vec3::Constant(1), Mat3::Identity(),
            {static_cast<float>(i % 3), 5});
  }
  return set;
}

TEST(Histograms, OfNormalizedKernelsCountTheirValues) {
  const test::KernelNumbers set = balls_apart(1000);
  const Histogram histogram =
      histogram_of(KernelField(set.source(), Reconstruction::kNormalized, 0));
  EXPECT_EQ(sum_of(histogram), 1000U);
  EXPECT_EQ(count_at(histogram, 0), 334U);
  EXPECT_EQ(count_at(histogram, 1), 333U);
  EXPECT_EQ(count_at(histogram, 2), 333U);
  const Histogram other = histogram_of(KernelField(set.source(), Reconstruction::kNormalized, 1));
  EXPECT_EQ(count_at(other, 5), 1000U);
}

// Balls that do not touch: at a centre the field is the kernel's own weight times its value.
TEST(Histograms, OfASumCountTheFieldAtTheCentres) {
  const test::KernelNumbers set = balls_apart(1000);
  const KernelField field(set.source(), Reconstruction::kSum, 0);
  const Histogram histogram = histogram_of(field);
  EXPECT_EQ(sum_of(histogram), 1000U);
  const double peak = KernelSampler(field).at(Vec3(10, 0, 0)).value;
  EXPECT_GT(peak, 0);
  EXPECT_EQ(count_at(histogram, 0), 334U);
  EXPECT_EQ(count_at(histogram, peak), 333U);
  EXPECT_EQ(count_at(histogram, 2 * peak), 333U);
}

TEST(Histograms, EndWhenTheyAreStopped) {
  std::stop_source stop;
  stop.request_stop();
  for (const Field& field : {Field(test::constant_field({4, 4, 4}, 7)),
                             Field(KernelField(balls_apart(3).source(), Reconstruction::kSum))}) {
    try {
      histogram_of(field, stop.get_token());
      ADD_FAILURE() << "was not stopped";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kCancelled);
    }
  }
}

}  // namespace curves_test
}  // namespace ovoid::viewer
