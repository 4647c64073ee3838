// SPDX-License-Identifier: Apache-2.0
#include "annotate/ticks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <set>

namespace ovoid::annotate {
namespace ticks_test {

std::string labels_of(const std::vector<Tick>& ticks) {
  std::string all;
  for (const Tick& tick : ticks) all += (all.empty() ? "" : " ") + tick.label;
  return all;
}

std::string linear_labels(double lo, double hi, int most = 6) {
  return labels_of(linear_ticks(lo, hi, most));
}

TEST(Ticks, AreRound) {
  EXPECT_EQ(linear_labels(0, 1), "0.0 0.2 0.4 0.6 0.8 1.0");
  EXPECT_EQ(linear_labels(-1024, 3071), "-1000 0 1000 2000 3000");
  EXPECT_EQ(linear_labels(0, 255), "0 50 100 150 200 250");
  EXPECT_EQ(linear_labels(-0.07, 0.031), "-0.06 -0.04 -0.02 0.00 0.02");
  EXPECT_EQ(linear_labels(-3, -1), "-3.0 -2.5 -2.0 -1.5 -1.0");
  EXPECT_EQ(linear_labels(0, 65535), "0 20000 40000 60000");
  EXPECT_EQ(linear_labels(0, 4e6), "0 1e6 2e6 3e6 4e6");
  EXPECT_EQ(linear_labels(0, 3e-5), "0 1e-5 2e-5 3e-5");
}

TEST(Ticks, SurviveExtremes) {
  EXPECT_EQ(linear_labels(1e-300, 4e-300), "1e-300 2e-300 3e-300 4e-300");
  EXPECT_EQ(linear_labels(1e9, 1e9 + 1),
            "1000000000.0 1000000000.2 1000000000.4 1000000000.6 1000000000.8 1000000001.0");
  EXPECT_EQ(linear_labels(-1.7e308, 1.7e308), "-1e308 0 1e308");
  EXPECT_EQ(linear_labels(5, 5), "");
  EXPECT_EQ(linear_labels(1, std::nextafter(1.0, 2.0)), "");  // no round values between
  EXPECT_EQ(linear_labels(5e-324, 1e-323), "");
  const std::vector<Tick> ends = linear_ticks(0.3, 0.9, 4);  // the ends belong to it
  EXPECT_EQ(ends.front().value, 0.4);
  EXPECT_EQ(linear_ticks(0.2, 1.0, 5).front().value, 0.2);
  EXPECT_EQ(linear_ticks(0.2, 1.0, 5).back().value, 1.0);
}

// Over random ranges of every magnitude: few enough, inside, rising, told apart, read back as what
// they are. The seed is printed by a failure.
TEST(Ticks, HoldTheirPromisesEverywhere) {
  std::mt19937_64 random(20);
  std::uniform_real_distribution<double> exponent(-290, 290);
  std::uniform_real_distribution<double> part(-1, 1);
  for (int i = 0; i < 3000; ++i) {
    const double scale = std::pow(10, exponent(random));
    double lo = part(random) * scale;
    double hi = lo + std::abs(part(random)) * scale * std::pow(10, part(random) * 5 - 5);
    if (!(lo < hi)) continue;
    const int most = 2 + static_cast<int>(random() % 9);
    SCOPED_TRACE(testing::Message() << "seed 20, " << lo << " to " << hi << ", most " << most);
    const std::vector<Tick> ticks = linear_ticks(lo, hi, most);
    EXPECT_LE(ticks.size(), static_cast<std::size_t>(most));
    std::set<std::string> labels;
    for (const Tick& tick : ticks) {
      EXPECT_GE(tick.value, lo);
      EXPECT_LE(tick.value, hi);
      EXPECT_NEAR(std::stod(tick.label), tick.value, 1e-13 * std::abs(tick.value));
      labels.insert(tick.label);
    }
    EXPECT_EQ(labels.size(), ticks.size()) << labels_of(ticks);
  }
}

TEST(Ticks, LogarithmicOnesArePowersOfTen) {
  const auto labels = [](double lo, double hi, int most) {
    return labels_of(TickScale(ValueScale::kLog, lo, hi).ticks(most));
  };
  EXPECT_EQ(labels(0.001, 1000, 8), "0.001 0.01 0.1 1 10 100 1000");
  EXPECT_EQ(labels(1e-20, 1e20, 6), "1e-14 1e-7 1 1e7 1e14");
  EXPECT_EQ(labels(2, 60, 8), "2 5 10 20 50");
  EXPECT_EQ(labels(3, 4, 6), "3.0 3.2 3.4 3.6 3.8 4.0");  // no three of them: linear
  EXPECT_EQ(labels(-5, 10, 4), "-5 0 5 10");              // no logarithm: linear
  EXPECT_EQ(labels_of(TickScale(ValueScale::kSymlog, -1000, 1000, 1).ticks(9)),
            "-1000 -100 -10 -1 0 1 10 100 1000");
}

TEST(Ticks, PlacesAndValuesAreInverse) {
  for (const ValueScale kind : {ValueScale::kLinear, ValueScale::kLog, ValueScale::kSymlog}) {
    const TickScale scale(kind, 0.01, 500, 2.0);
    EXPECT_NEAR(scale.place(0.01), 0, 1e-15);
    EXPECT_NEAR(scale.place(500), 1, 1e-15);
    for (const double t : {0.0, 0.1, 0.5, 0.77, 1.0}) {
      EXPECT_NEAR(scale.place(scale.value(t)), t, 1e-13);
    }
  }
  EXPECT_NEAR(TickScale(ValueScale::kLog, 1, 100).value(0.5), 10, 1e-12);
  EXPECT_EQ(TickScale(ValueScale::kLinear, 7, 7).place(7), 0.5);
  EXPECT_EQ(TickScale(ValueScale::kLinear, 7, 7).value(0.3), 7);
  EXPECT_EQ(TickScale(ValueScale::kLinear, -1.7e308, 1.7e308).place(0), 0.5);
}

TEST(Ticks, NumbersAsText) {
  EXPECT_EQ(number_text(0), "0");
  EXPECT_EQ(number_text(-0.0), "0");
  EXPECT_EQ(number_text(0.1), "0.1");
  EXPECT_EQ(number_text(1450), "1450");
  EXPECT_EQ(number_text(1e-300), "1e-300");
  EXPECT_EQ(number_text(5e-324), "5e-324");
  EXPECT_EQ(number_text(-2.5e7), "-2.5e7");
  EXPECT_EQ(number_text(std::numeric_limits<double>::max()), "1.7976931348623157e308");
  EXPECT_EQ(number_text(1000000000.5), "1000000000.5");
  EXPECT_EQ(number_text(3.14159, 0.01), "3.14");
  EXPECT_EQ(number_text(-0.0001, 0.01), "0");
  EXPECT_EQ(number_text(-1024.4, 5), "-1024");
  EXPECT_EQ(number_text(0.5, 0.001), "0.5");
  EXPECT_EQ(number_text(1.2346e-9, 1e-12), "1.235e-9");
}

TEST(Ticks, RoundBelow) {
  EXPECT_EQ(round_below(1), 1);
  EXPECT_EQ(round_below(1.99), 1);
  EXPECT_EQ(round_below(2), 2);
  EXPECT_EQ(round_below(49), 20);
  EXPECT_EQ(round_below(0.5), 0.5);
  EXPECT_EQ(round_below(1000), 1000);
  EXPECT_EQ(round_below(9.99e-7), 5e-7);
}

}  // namespace ticks_test
}  // namespace ovoid::annotate
