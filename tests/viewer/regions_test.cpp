// SPDX-License-Identifier: Apache-2.0
// Regions of looks by value and gradient on their canvas: where they lie, what the mouse takes hold
// of, and what it makes of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "ovoid/error.h"
#include "region_plane.h"
#include "support/volumes.h"

namespace ovoid::viewer {
namespace regions_test {

const PlaneAxes kCtAxes{-1000, 1500, 50000};
// 2500 by 500 units: a value per unit, 100 of the gradient.
const PlaneCanvas kCtCanvas{kCtAxes, 10, 20, 2510, 520};

LookRegion boundary() {
  LookRegion region;
  region.values = {0, 800};
  region.gradients = {10000, 40000};
  return region;
}

LookRegion moved(const LookRegion& region, Grip grip, double right, double up) {
  return moved_region(region, grip, {100, 20000}, {100 + right, 20000 + up}, kCtAxes);
}

void expect_valid(const LookRegion& region) { EXPECT_NO_THROW(TransferFunction2D({region})); }

TEST(RegionPlane, PlacesThereAndBack) {
  EXPECT_EQ(kCtCanvas.x_of(-1000), 10);
  EXPECT_EQ(kCtCanvas.x_of(1500), 2510);
  EXPECT_EQ(kCtCanvas.y_of(0), 520);  // gradients upwards
  EXPECT_EQ(kCtCanvas.y_of(50000), 20);
  for (const double share : {-0.2, 0.0, 0.3, 1.0, 1.7}) {
    const PlanePoint at = kCtCanvas.at(10 + 2500 * share, 20 + 500 * share);
    EXPECT_NEAR(kCtCanvas.x_of(at.value), 10 + 2500 * share, 1e-9);
    EXPECT_NEAR(kCtCanvas.y_of(at.gradient), 20 + 500 * share, 1e-9);
  }
}

// Fails if a region that flags name cannot be reached, or hides what was counted.
TEST(RegionPlane, AxesHoldWhatWasCountedAndWhatIsNamed) {
  cli::Histogram2D histogram;
  histogram.value_lo = -1000;
  histogram.value_hi = 1000;
  histogram.gradient_hi = 100;
  const ValueRange range{5, 6};
  PlaneAxes axes = plane_axes(&histogram, nullptr, range);
  EXPECT_EQ(axes.value_lo, -1000);
  EXPECT_EQ(axes.gradient_hi, 100);
  LookRegion region = boundary();
  region.values = {500, 1500};
  region.gradients = {0, 150};
  const TransferFunction2D beyond({region});
  axes = plane_axes(&histogram, &beyond, range);
  EXPECT_EQ(axes.value_lo, -1000);
  EXPECT_EQ(axes.value_hi, 1500);
  EXPECT_EQ(axes.gradient_hi, 150);
  region.values = {-1e30, 1e30};
  region.gradients = {0, 1e30};
  const TransferFunction2D far({region});
  axes = plane_axes(&histogram, &far, range);
  EXPECT_EQ(axes.value_lo, -3000);
  EXPECT_EQ(axes.value_hi, 3000);
  EXPECT_EQ(axes.gradient_hi, 300);
  axes = plane_axes(nullptr, nullptr, range);
  EXPECT_EQ(axes.value_lo, 5);
  EXPECT_EQ(axes.value_hi, 6);
  const TransferFunction2D table({-3, 3, 2}, {0, 7, 2}, std::vector<TransferFunction2D::Rgba>(4));
  axes = plane_axes(nullptr, &table, range);
  EXPECT_EQ(axes.value_lo, -3);
  EXPECT_EQ(axes.gradient_hi, 7);
  axes = plane_axes(nullptr, nullptr, ValueRange{4, 4});
  EXPECT_LT(axes.value_lo, axes.value_hi);
}

TEST(RegionPlane, ATrapezoidIsTakenHoldOfWhereItIs) {
  LookRegion trapezoid = boundary();
  trapezoid.foot = 0.5;
  const std::vector<LookRegion> regions = {trapezoid};
  const auto under = [&](double value, double gradient, int selected) {
    return region_under(regions, kCtCanvas, {kCtCanvas.x_of(value), kCtCanvas.y_of(gradient)},
                        selected, {});
  };
  EXPECT_EQ(under(400, 15000, -1).grip, Grip::kBody);
  EXPECT_EQ(under(750, 39000, -1).region, 0);
  EXPECT_EQ(under(750, 12000, -1).region, -1);  // beside the narrow foot
  EXPECT_EQ(under(400, 9000, -1).region, -1);
  EXPECT_EQ(under(400, 41000, -1).region, -1);
  trapezoid.shape = LookRegion::Shape::kGaussian;  // has no foot
  EXPECT_EQ(region_under(std::vector{trapezoid}, kCtCanvas,
                         {kCtCanvas.x_of(750), kCtCanvas.y_of(12000)}, -1, {})
                .region,
            0);
}

// Each grip is found where it is drawn, of the selected region alone.
TEST(RegionPlane, GripsAreFoundWhereTheyAre) {
  LookRegion region = boundary();
  region.foot = 0.4;
  const std::vector<LookRegion> regions = {region};
  const Reach reach;
  std::set<std::string> names;
  for (const Grip grip : grips_of(region)) {
    const PlanePlace place = place_of(region, grip, kCtCanvas, reach.below);
    const RegionHit hit = region_under(regions, kCtCanvas, {place.x + 1, place.y + 1}, 0, reach);
    EXPECT_EQ(hit.grip, grip) << name_of(grip);
    EXPECT_EQ(hit.region, 0);
    const RegionHit other = region_under(regions, kCtCanvas, {place.x + 1, place.y + 1}, -1, reach);
    EXPECT_TRUE(other.grip == Grip::kBody || other.grip == Grip::kNone) << name_of(grip);
    names.insert(name_of(grip));
  }
  EXPECT_EQ(names.size(), 10U);
  region.shape = LookRegion::Shape::kGaussian;
  EXPECT_EQ(grips_of(region).size(), 8U);
}

TEST(RegionPlane, TheSelectedRegionIsTakenThenTheUppermost) {
  LookRegion upper = boundary();
  upper.values = {400, 1200};
  const std::vector<LookRegion> regions = {boundary(), upper};
  const PlanePlace both{kCtCanvas.x_of(600), kCtCanvas.y_of(20000)};
  EXPECT_EQ(region_under(regions, kCtCanvas, both, -1, {}).region, 1);
  EXPECT_EQ(region_under(regions, kCtCanvas, both, 0, {}).region, 0);
  EXPECT_EQ(region_under(regions, kCtCanvas, both, 7, {}).region, 1);  // of a list that was longer
  const PlanePlace lower{kCtCanvas.x_of(200), kCtCanvas.y_of(20000)};
  EXPECT_EQ(region_under(regions, kCtCanvas, lower, 1, {}).region, 0);
}

TEST(RegionPlane, AnOutlineHasTheFootsWidth) {
  LookRegion region = boundary();
  region.foot = 0.5;
  const auto corners = outline_of(region, kCtCanvas);
  EXPECT_NEAR(corners[0].x, kCtCanvas.x_of(200), 1e-9);
  EXPECT_NEAR(corners[1].x, kCtCanvas.x_of(600), 1e-9);
  EXPECT_NEAR(corners[2].x, kCtCanvas.x_of(800), 1e-9);
  EXPECT_NEAR(corners[3].x, kCtCanvas.x_of(0), 1e-9);
  EXPECT_NEAR(corners[0].y, kCtCanvas.y_of(10000), 1e-9);
  EXPECT_NEAR(corners[2].y, kCtCanvas.y_of(40000), 1e-9);
}

TEST(RegionPlane, ABodyMovesAsAWholeAndStaysInside) {
  const LookRegion right = moved(boundary(), Grip::kBody, 300, -4000);
  EXPECT_EQ(right.values, (std::array<double, 2>{300, 1100}));
  EXPECT_EQ(right.gradients, (std::array<double, 2>{6000, 36000}));
  const LookRegion far = moved(boundary(), Grip::kBody, 1e6, 1e9);
  EXPECT_EQ(far.values, (std::array<double, 2>{700, 1500}));
  EXPECT_EQ(far.gradients, (std::array<double, 2>{20000, 50000}));
  const LookRegion low = moved(boundary(), Grip::kBody, -1e6, -1e9);
  EXPECT_EQ(low.values, (std::array<double, 2>{-1000, -200}));
  EXPECT_EQ(low.gradients, (std::array<double, 2>{0, 30000}));
}

// What was typed beyond the axes is not lost by a touch.
TEST(RegionPlane, WhatLiesBeyondTheAxesStaysThere) {
  LookRegion beyond = boundary();
  beyond.values = {-1e5, 1e5};
  beyond.gradients = {0, 1e9};
  const LookRegion same = moved(beyond, Grip::kBody, 500, 500);
  EXPECT_EQ(same.values, beyond.values);
  EXPECT_EQ(same.gradients, beyond.gradients);
  const LookRegion narrower = moved(beyond, Grip::kRight, -99000, 0);
  EXPECT_EQ(narrower.values[0], -1e5);
  EXPECT_EQ(narrower.values[1], 1000);
}

TEST(RegionPlane, AClickChangesNothing) {
  LookRegion region = boundary();
  region.values = {0.1234567, 800.7654321};
  region.gradients = {9999.999, 40000.123};
  region.foot = 0.123456;
  for (const Grip grip : grips_of(region)) {
    const LookRegion same = moved(region, grip, 0, 0);
    EXPECT_EQ(same.values, region.values) << name_of(grip);
    EXPECT_EQ(same.gradients, region.gradients) << name_of(grip);
    EXPECT_EQ(same.foot, region.foot) << name_of(grip);
  }
}

TEST(RegionPlane, EdgesAndCornersMoveTheirEnds) {
  EXPECT_EQ(moved(boundary(), Grip::kLeft, -200, 700).values, (std::array<double, 2>{-200, 800}));
  EXPECT_EQ(moved(boundary(), Grip::kLeft, -200, 700).gradients, boundary().gradients);
  EXPECT_EQ(moved(boundary(), Grip::kTop, 30, 5000).gradients,
            (std::array<double, 2>{10000, 45000}));
  const LookRegion corner = moved(boundary(), Grip::kBottomRight, 100, -3000);
  EXPECT_EQ(corner.values, (std::array<double, 2>{0, 900}));
  EXPECT_EQ(corner.gradients, (std::array<double, 2>{7000, 40000}));
  EXPECT_EQ(moved(boundary(), Grip::kBottom, 0, -1e9).gradients[0], 0);  // the ground, exactly
}

// Whatever the mouse does, a function can be made of it.
TEST(RegionPlane, NoEdgePassesTheOpposite) {
  for (const Grip grip : grips_of(boundary())) {
    for (const double right : {-1e7, -900.0, 900.0, 1e7}) {
      for (const double up : {-1e9, -40000.0, 40000.0, 1e9}) {
        const LookRegion region = moved(boundary(), grip, right, up);
        expect_valid(region);
        EXPECT_GE(region.values[0], -1000) << name_of(grip);
        EXPECT_LE(region.values[1], 1500) << name_of(grip);
        EXPECT_LE(region.gradients[1], 50000) << name_of(grip);
      }
    }
  }
}

TEST(RegionPlane, FeetMoveTogether) {
  EXPECT_EQ(moved(boundary(), Grip::kRightFoot, -200, 0).foot, 0.5);
  EXPECT_EQ(moved(boundary(), Grip::kLeftFoot, 200, 0).foot, 0.5);
  EXPECT_EQ(moved(boundary(), Grip::kLeftFoot, 1e6, 0).foot, 0);
  EXPECT_EQ(moved(boundary(), Grip::kLeftFoot, -1e6, 0).foot, 1);
  EXPECT_EQ(moved(boundary(), Grip::kLeftFoot, 200, 0).values, boundary().values);
}

// No more digits than pixels can show: what is copied as a command can be read.
TEST(RegionPlane, DraggedNumbersAreRound) {
  EXPECT_EQ(moved(boundary(), Grip::kRight, 33.33333, 0).values[1], 833);
  EXPECT_EQ(moved(boundary(), Grip::kTop, 0, 777.77).gradients[1], 40780);
  const PlaneAxes small{0, 0.25, 1e-3};
  LookRegion region;
  region.values = {0.1, 0.2};
  region.gradients = {0, 5e-4};
  const LookRegion dragged = moved_region(region, Grip::kLeft, {0, 0}, {0.0123456, 0}, small);
  EXPECT_EQ(dragged.values[0], 0.1123);
}

TEST(RegionPlane, ARegionIsDrawnFromCornerToCorner) {
  const auto drawn = region_between({500, 30000}, {-200, 4000}, kCtAxes);
  ASSERT_TRUE(drawn);
  EXPECT_EQ(drawn->values, (std::array<double, 2>{-200, 500}));
  EXPECT_EQ(drawn->gradients, (std::array<double, 2>{4000, 30000}));
  const auto cut = region_between({500, -30000}, {1e6, 1e6}, kCtAxes);
  ASSERT_TRUE(cut);
  EXPECT_EQ(cut->values, (std::array<double, 2>{500, 1500}));
  EXPECT_EQ(cut->gradients, (std::array<double, 2>{0, 50000}));
  EXPECT_FALSE(region_between({500, 30000}, {505, 4000}, kCtAxes));  // a slip of the hand
  EXPECT_FALSE(region_between({-5000, 1000}, {-4000, 9000}, kCtAxes));
}

TEST(RegionPlane, ARegionAroundAPlaceIsWholeWhereverThatIs) {
  for (const double value : {-1e9, -1000.0, 250.0, 1500.0, 1e9}) {
    for (const double gradient : {-5.0, 0.0, 25000.0, 50000.0, 1e9}) {
      const LookRegion region = region_around({value, gradient}, kCtAxes);
      expect_valid(region);
      EXPECT_NEAR(region.values[1] - region.values[0], 500, 10);
      EXPECT_NEAR(region.gradients[1] - region.gradients[0], 12500, 100);
    }
  }
  const LookRegion region = region_around({250, 25000}, kCtAxes);
  EXPECT_EQ(region.values, (std::array<double, 2>{0, 500}));
}

TEST(RegionPlane, ColorsDifferFromThoseThatAreThere) {
  std::vector<LookRegion> regions;
  std::set<Rgb> colors;
  for (int i = 0; i < 6; ++i) {
    LookRegion region = boundary();
    region.rgb = color_for_region(regions);
    colors.insert(region.rgb);
    regions.push_back(region);
  }
  EXPECT_EQ(colors.size(), 6U);
}

// A ball of 1000 in 0: its boundary is all that is steep.
TEST(FirstRegions, LieOverTheBoundary) {
  const LatticeField ball = test::make_field(
      {32, 32, 32},
      [](auto i, auto j, auto k) {
        const double r = std::hypot(static_cast<double>(i) - 15.5, static_cast<double>(j) - 15.5,
                                    static_cast<double>(k) - 15.5);
        return 1000 / (1 + std::exp((r - 10) / 0.5));
      },
      {});
  const cli::Histogram2D histogram = cli::histogram_2d_of(ball);
  TransferFunction tf;
  tf.colors = {{0, {0, 0, 0}}, {1000, {1, 0, 0}}};
  const PlaneAxes axes = plane_axes(&histogram, nullptr, {});
  const LookRegion region = first_region(&histogram, tf, axes);
  expect_valid(region);
  EXPECT_GT(region.values[0], 20);  // neither of the two materials
  EXPECT_LT(region.values[0], 480);
  EXPECT_GT(region.values[1], 520);
  EXPECT_LT(region.values[1], 980);
  EXPECT_GT(region.gradients[0], 0.1 * axes.gradient_hi);
  EXPECT_NEAR(region.gradients[1], axes.gradient_hi, 1e-3 * axes.gradient_hi);
  EXPECT_NEAR(region.rgb[0], 0.5, 0.2);  // the look's there
  EXPECT_EQ(region.rgb[1], 0);
}

// Of a field without a boundary, and where nothing could be counted.
TEST(FirstRegions, AreThereWithoutABoundary) {
  const cli::Histogram2D flat = cli::histogram_2d_of(test::constant_field({8, 8, 8}, 7));
  const TransferFunction tf;
  expect_valid(first_region(&flat, tf, plane_axes(&flat, nullptr, {})));
  const LookRegion usual = first_region(nullptr, tf, plane_axes(nullptr, nullptr, {-2, 6}));
  expect_valid(usual);
  EXPECT_EQ(usual.values, (std::array<double, 2>{2, 6}));
}

TEST(FirstRegions, NothingIsCountedWhereNothingIs) {
  const LatticeField none = test::constant_field({4, 4, 4}, test::kMissing);
  try {
    cli::histogram_2d_of(none);
    ADD_FAILURE() << "was counted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
  }
  std::stop_source stop;
  stop.request_stop();
  try {
    cli::histogram_2d_of(test::constant_field({4, 4, 4}, 7), stop.get_token());
    ADD_FAILURE() << "was not stopped";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kCancelled);
  }
}

// Fails if what is asked of a lattice without a copy is something else.
TEST(Histograms2D, OfLargeLatticesAreTheSameOfFewerPlaces) {
  const LatticeField field = test::make_field({24, 24, 24},
                                              [](auto i, auto j, auto k) {
                                                return static_cast<double>(i * i + 3 * j) -
                                                       std::sin(static_cast<double>(k));
                                              },
                                              {});
  const cli::Histogram2D copied = cli::histogram_2d_of(field);
  const cli::Histogram2D asked = cli::histogram_2d_of(field, {}, 0);
  const double span = copied.value_hi - copied.value_lo;
  EXPECT_NEAR(asked.value_lo, copied.value_lo, 0.01 * span);
  EXPECT_NEAR(asked.value_hi, copied.value_hi, 0.01 * span);
  EXPECT_NEAR(asked.gradient_hi, copied.gradient_hi, 0.02 * copied.gradient_hi);
  const auto half_of = [](const cli::Histogram2D& of) {  // the share of the lower half of values
    double left = 0, all = 0;
    for (std::size_t i = 0; i < of.counts.size(); ++i) {
      all += of.counts[i];
      if (i % cli::Histogram2D::kColumns < cli::Histogram2D::kColumns / 2) left += of.counts[i];
    }
    return left / all;
  };
  EXPECT_NEAR(half_of(asked), half_of(copied), 0.01);
}

TEST(Histograms2D, AreAsBrightAsTheirLogarithm) {
  cli::Histogram2D histogram;
  histogram.counts.assign(std::size_t{cli::Histogram2D::kColumns} * cli::Histogram2D::kRows, 0);
  histogram.counts[0] = 1;
  histogram.counts[1] = 7;
  histogram.counts[2] = 7;
  const std::vector<float> brightness = cli::brightness_of(histogram);
  EXPECT_EQ(brightness[1], 1);
  EXPECT_NEAR(brightness[0], std::log(2) / std::log(8), 1e-6);
  EXPECT_EQ(brightness[3], 0);
}

TEST(RoundNumbers, AreRoundAndBetween) {
  EXPECT_EQ(round_numbers(-1000, 1500, 4), (std::vector<double>{-1000, 0, 1000}));
  EXPECT_EQ(round_numbers(0, 50385, 4), (std::vector<double>{0, 20000, 40000}));
  const std::vector<double> small = round_numbers(0.12, 0.31, 4);
  ASSERT_EQ(small.size(), 4U);
  EXPECT_NEAR(small.front(), 0.15, 1e-12);
  EXPECT_NEAR(small.back(), 0.30, 1e-12);
  EXPECT_TRUE(round_numbers(1, 1, 4).empty());
  EXPECT_TRUE(round_numbers(1e30, 1e30 + 1, 4).empty());
  for (const double span : {1e-9, 0.7, 3.0, 9.99, 1e20})
    EXPECT_LE(round_numbers(0, span, 4).size(), 5U) << span;
}

}  // namespace regions_test
}  // namespace ovoid::viewer
