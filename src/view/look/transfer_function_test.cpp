// SPDX-License-Identifier: Apache-2.0
#include "ovoid/transfer_function.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <utility>

#include "ovoid/error.h"
#include "support/numbers.h"
#include "view/look/value_scale.h"

namespace ovoid {
namespace transfer_function_test {

TransferFunction with_opacities(std::vector<OpacityPoint> points) {
  TransferFunction tf;
  tf.opacities = std::move(points);
  return tf;
}

TransferFunction with_colors(std::vector<ColorPoint> points, ColorSpace space = ColorSpace::kRgb) {
  TransferFunction tf;
  tf.colors = std::move(points);
  tf.color_space = space;
  return tf;
}

TEST(TransferFunction, EmptyCurvesAreAGrayRampAndOpaque) {
  const TransferFunction tf;
  EXPECT_EQ(tf.color_at(0.25), (Rgb{0.25, 0.25, 0.25}));
  EXPECT_EQ(tf.color_at(-3), (Rgb{0, 0, 0}));
  EXPECT_EQ(tf.color_at(kInfinity), (Rgb{1, 1, 1}));
  EXPECT_EQ(tf.opacity_at(-7), 1.0);
  EXPECT_EQ(tf.lo(), 0.0);
  EXPECT_EQ(tf.hi(), 1.0);
}

// Fails if an end is cut instead of extended, or if the segment is found on the wrong side of a
// point.
TEST(TransferFunction, IsLinearBetweenPointsAndExtendsTheEnds) {
  const TransferFunction tf = with_opacities({{-2, 0.25}, {2, 0.75}, {4, 0}});
  EXPECT_EQ(tf.opacity_at(-kInfinity), 0.25);
  EXPECT_EQ(tf.opacity_at(-2), 0.25);
  EXPECT_EQ(tf.opacity_at(-1), 0.375);
  EXPECT_EQ(tf.opacity_at(2), 0.75);
  EXPECT_EQ(tf.opacity_at(3), 0.375);
  EXPECT_EQ(tf.opacity_at(4), 0.0);
  EXPECT_EQ(tf.opacity_at(1e300), 0.0);

  const TransferFunction colors = with_colors({{0, {0, 1, 0.5}}, {4, {1, 0, 0.5}}});
  EXPECT_EQ(colors.color_at(-1), (Rgb{0, 1, 0.5}));
  EXPECT_EQ(colors.color_at(1), (Rgb{0.25, 0.75, 0.5}));
  EXPECT_EQ(colors.color_at(5), (Rgb{1, 0, 0.5}));
}

TEST(TransferFunction, EqualXIsAStepTheLaterPointHolding) {
  const TransferFunction tf =
      with_opacities({{0, 0.125}, {1, 0.125}, {1, 0.5}, {1, 0.75}, {2, 0.75}});
  EXPECT_EQ(tf.opacity_at(std::nextafter(1.0, 0.0)), 0.125);
  EXPECT_EQ(tf.opacity_at(1), 0.75);
  const TransferFunction first = with_opacities({{1, 0.25}, {1, 0.5}});
  EXPECT_EQ(first.opacity_at(0.999), 0.25);
  EXPECT_EQ(first.opacity_at(1), 0.5);
}

TEST(TransferFunction, OfNotANumberIsTheNanColourAndTransparent) {
  TransferFunction tf = with_opacities({{0, 1}, {1, 1}});
  tf.nan_color = {0.5, 0.25, 0.125};
  EXPECT_EQ(tf.color_at(kNan), tf.nan_color);
  EXPECT_EQ(tf.opacity_at(kNan), 0.0);
}

TEST(TransferFunction, MidpointMovesTheHalfWayValue) {
  const TransferFunction tf = with_opacities({{0, 0, 0.25, 0}, {8, 1}});
  EXPECT_EQ(tf.opacity_at(1), 0.25);
  EXPECT_EQ(tf.opacity_at(2), 0.5);
  EXPECT_DOUBLE_EQ(tf.opacity_at(5), 0.75);
  // At the very ends it acts as 1e-5 and 1 - 1e-5: half the way is done at once, the rest in a
  // straight line.
  EXPECT_NEAR(with_opacities({{0, 0, 0, 0}, {1, 1}}).opacity_at(0.5), 0.75, 1e-5);
  EXPECT_NEAR(with_opacities({{0, 0, 1, 0}, {1, 1}}).opacity_at(0.5), 0.25, 1e-5);
}

TEST(TransferFunction, SharpnessAtItsLimits) {
  const TransferFunction step = with_opacities({{0, 0.25, 0.25, 1}, {4, 1}});
  EXPECT_EQ(step.opacity_at(std::nextafter(1.0, 0.0)), 0.25);
  EXPECT_EQ(step.opacity_at(1), 1.0);
  const TransferFunction line = with_opacities({{0, 0, 0.5, 0.0099}, {4, 1}});
  EXPECT_EQ(line.opacity_at(1), 0.25);
}

// Worked by hand for sharpness 0.1: power 2, slopes 0.9. At s = 1/4: s -> 0.5 * (1/2)^2 = 1/8; the
// Hermite sum is (3/64 - 2/512) + 0.9 (1/512 - 2/64 + 1/8) + 0.9 (1/512 - 1/64) = 0.04296875 + 0.9
// (0.095703125 - 0.013671875) = 0.116796875.
TEST(TransferFunction, SharpnessBendsTheCurve) {
  const TransferFunction tf = with_opacities({{0, 0, 0.5, 0.1}, {1, 1}});
  EXPECT_NEAR(tf.opacity_at(0.25), 0.116796875, 1e-15);
  EXPECT_NEAR(tf.opacity_at(0.75), 1 - 0.116796875, 1e-15);
  EXPECT_DOUBLE_EQ(tf.opacity_at(0.5), 0.5);
}

// vtkPiecewiseFunction 9.1's values for a falling and a rising segment, ten digits.
TEST(TransferFunction, OpacityAsVtk) {
  const TransferFunction tf = with_opacities({{0, 0.9, 0.3, 0.4}, {2, 0.2, 0.7, 0.75}, {3, 0.6}});
  const double expected[][2] = {
      {0.1, 0.899972990354}, {0.4, 0.868863813808},  {0.6, 0.550000000000}, {0.7, 0.422029925432},
      {1.2, 0.213558377920}, {2, 0.200000000000},    {2.3, 0.200037378394}, {2.6, 0.228386628447},
      {2.7, 0.400000000000}, {2.71, 0.467672251089}, {2.9, 0.599995598393},
  };
  for (const auto& [x, opacity] : expected) EXPECT_NEAR(tf.opacity_at(x), opacity, 1e-10) << x;
}

// Relevance bounds stand on this: between two points the curve never leaves them and never turns
// back.
TEST(TransferFunction, EverySegmentIsMonotonic) {
  for (double midpoint = 0; midpoint <= 1; midpoint += 0.125) {
    for (double sharpness = 0; sharpness <= 1; sharpness += 0.0625) {
      const TransferFunction tf = with_opacities({{0, 0.75, midpoint, sharpness}, {1, 0.125}});
      double before = 0.75;
      for (int i = 0; i <= 1000; ++i) {
        const double now = tf.opacity_at(i / 1000.0);
        ASSERT_LE(now, before + 1e-15)
            << midpoint << ' ' << sharpness << ' ' << i;  // rounding of the sum
        ASSERT_GE(now, 0.125);
        before = now;
      }
    }
  }
}

TEST(TransferFunction, StepColoursBelongToTheRightPoint) {
  const TransferFunction tf =
      with_colors({{0, {1, 0, 0}}, {1, {0, 1, 0}}, {2, {0, 0, 1}}}, ColorSpace::kStep);
  EXPECT_EQ(tf.color_at(0), (Rgb{1, 0, 0}));
  EXPECT_EQ(tf.color_at(0.01), (Rgb{0, 1, 0}));
  EXPECT_EQ(tf.color_at(1), (Rgb{0, 1, 0}));
  EXPECT_EQ(tf.color_at(1.5), (Rgb{0, 0, 1}));
}

TEST(TransferFunction, MapRangeMovesEveryPointAndKeepsSteps) {
  TransferFunction tf = with_opacities({{1, 0}, {2, 0}, {2, 1}, {3, 1}});
  tf.colors = {{-1, {0, 0, 0}}, {3, {1, 1, 1}}};
  tf.map_range(0.1, 0.7);
  EXPECT_EQ(tf.lo(), 0.1);  // the ends exactly
  EXPECT_EQ(tf.hi(), 0.7);
  EXPECT_EQ(tf.colors[0].x, 0.1);
  EXPECT_EQ(tf.colors[1].x, 0.7);
  EXPECT_NEAR(tf.opacities[0].x, 0.4, 1e-16);
  EXPECT_NEAR(tf.opacities[1].x, 0.55, 2e-16);
  EXPECT_EQ(tf.opacities[1].x, tf.opacities[2].x);
}

TEST(TransferFunction, MapRangeToItselfChangesNothing) {
  TransferFunction tf = with_opacities({{0.1, 0}, {0.3, 1}, {0.7, 1}});
  tf.colors = {{0.2, {1, 1, 1}}};
  tf.map_range(0.1, 0.7);
  EXPECT_EQ(tf.opacities[1].x, 0.3);
  EXPECT_EQ(tf.colors[0].x, 0.2);
}

TEST(TransferFunction, MapRangeTakesTheImplicitRampAlong) {
  TransferFunction empty;
  empty.map_range(10, 20);
  EXPECT_NEAR(empty.color_at(12.5)[0], 0.25, 1e-15);
  TransferFunction tf = with_opacities({{0, 0}, {2, 1}});  // the ramp covers its lower half
  tf.map_range(10, 20);
  EXPECT_NEAR(tf.color_at(12.5)[1], 0.5, 1e-15);
}

TEST(TransferFunction, MapRangeOfOnePlaceGoesToTheMiddle) {
  TransferFunction tf = with_opacities({{5, 0}, {5, 1}});
  tf.colors = {{5, {1, 0, 0}}};
  tf.map_range(0, 1);
  EXPECT_EQ(tf.opacity_at(0.49), 0.0);
  EXPECT_EQ(tf.opacity_at(0.5), 1.0);
}

TEST(TransferFunction, MapRangeRefusesAnEmptyRange) {
  TransferFunction tf;
  EXPECT_THROW(tf.map_range(1, 1), Error);
  EXPECT_THROW(tf.map_range(1, 0), Error);
  EXPECT_THROW(tf.map_range(0, kInfinity), Error);
  EXPECT_THROW(tf.map_range(kNan, 1), Error);
}

TEST(TransferFunction, SortIsStable) {
  TransferFunction tf = with_opacities({{2, 0.5}, {kNan, 0.9}, {1, 0.1}, {2, 0.6}, {1, 0.2}});
  tf.sort();
  const double expected[] = {0.1, 0.2, 0.5, 0.6, 0.9};
  for (int i = 0; i < 5; ++i) EXPECT_EQ(tf.opacities[i].opacity, expected[i]);
}

// ---- scales

TransferFunction on(ValueScale scale, TransferFunction tf, double linear_width = 1.0) {
  tf.scale = scale;
  tf.linear_width = linear_width;
  return tf;
}

TEST(ValueScale, CurvesRunAlongTheLogarithm) {
  const TransferFunction tf =
      on(ValueScale::kLog, with_colors({{1, {0, 0, 0}}, {100, {1, 0.5, 0}}, {1e6, {1, 1, 1}}}));
  EXPECT_NEAR(tf.color_at(10)[0], 0.5, 1e-15);
  EXPECT_NEAR(tf.color_at(1e4)[1], 0.75, 1e-15);
  for (const double below : {1.0, 0.5, 0.0, -3.0, -kInfinity}) {
    EXPECT_EQ(tf.color_at(below), (Rgb{0, 0, 0})) << below;
  }
  EXPECT_EQ(tf.color_at(kInfinity), (Rgb{1, 1, 1}));
  const TransferFunction opacity = on(ValueScale::kLog, with_opacities({{0.01, 0.25}, {1, 0.75}}));
  EXPECT_NEAR(opacity.opacity_at(0.1), 0.5, 1e-15);
  EXPECT_EQ(opacity.opacity_at(-1), 0.25);
}

// vtkPiecewiseFunction 9.1 with UseLogScale on, twelve digits.
TEST(ValueScale, LogarithmicOpacityAsVtk) {
  const TransferFunction tf =
      on(ValueScale::kLog, with_opacities({{1, 0.9, 0.3, 0.4}, {50, 0.2, 0.7, 0.75}, {1000, 0.6}}));
  const double expected[][2] = {
      {0.5, 0.900000000000}, {1.2, 0.899980996420}, {3, 0.666546903881},   {4, 0.412914035516},
      {10, 0.215734830339},  {40, 0.200000754476},  {60, 0.200000000048},  {200, 0.201678942040},
      {400, 0.381042931253}, {500, 0.591881795053}, {900, 0.599999999389}, {2000, 0.6},
  };
  for (const auto& [x, opacity] : expected) EXPECT_NEAR(tf.opacity_at(x), opacity, 1e-10) << x;
}

// vtkColorTransferFunction 9.1 with SetScaleToLog10, six digits: green at 10 between red at 1 and
// blue at 100.
TEST(ValueScale, LogarithmicColoursAsVtk) {
  struct Row {
    ColorSpace space;
    double x;
    Rgb expected;
  };
  const Row rows[] = {
      {ColorSpace::kHsv, 1.5, {1.000000, 0.352183, 0.000000}},
      {ColorSpace::kHsv, 20, {0.000000, 1.000000, 0.602060}},
      {ColorSpace::kHsv, 99, {0.000000, 0.008730, 1.000000}},
      {ColorSpace::kDiverging, 1.5, {1.000000, 0.595192, 0.296055}},
      {ColorSpace::kDiverging, 8, {0.505133, 1.000000, 0.407713}},
      {ColorSpace::kDiverging, 70, {0.790067, 0.422635, 1.000000}},
  };
  for (const Row& row : rows) {
    const TransferFunction tf =
        on(ValueScale::kLog,
           with_colors({{1, {1, 0, 0}}, {10, {0, 1, 0}}, {100, {0, 0, 1}}}, row.space));
    const Rgb rgb = tf.color_at(row.x);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(rgb[c], row.expected[c], 1e-6) << row.x << ' ' << c;
  }
}

TEST(ValueScale, SymlogIsStraightAroundZeroAndOdd) {
  const TransferFunction tf = on(ValueScale::kSymlog, with_opacities({{-1e6, 0}, {1e6, 1}}), 0.001);
  EXPECT_EQ(tf.opacity_at(0), 0.5);
  EXPECT_NEAR(tf.opacity_at(3) + tf.opacity_at(-3), 1.0, 1e-15);
  const double slope = tf.opacity_at(1e-6) - 0.5;  // a thousandth of the linear width
  EXPECT_NEAR(tf.opacity_at(2e-6) - 0.5, 2 * slope, 1e-3 * slope);
  const double decade = tf.opacity_at(1e5) - tf.opacity_at(1e4);  // far out, decades are equal
  EXPECT_NEAR(tf.opacity_at(1e4) - tf.opacity_at(1e3), decade, 1e-5 * decade);
}

TEST(ValueScale, PlacesReturn) {
  for (const ValueScale scale : {ValueScale::kLinear, ValueScale::kLog, ValueScale::kSymlog}) {
    for (const double x : {1e-12, 0.3, 1.0, 7.0, 1e9}) {
      EXPECT_NEAR(view::value_at(scale, 0.1, view::along(scale, 0.1, x)), x, 1e-13 * (x + 1));
      if (scale == ValueScale::kLog) continue;
      EXPECT_NEAR(view::value_at(scale, 0.1, view::along(scale, 0.1, -x)), -x, 1e-13 * (x + 1));
    }
  }
  EXPECT_EQ(view::along(ValueScale::kLog, 1, 0), -kInfinity);
  EXPECT_EQ(view::along(ValueScale::kLog, 1, -5), -kInfinity);
}

// Fails if neighbouring values with one logarithm divide by zero.
TEST(ValueScale, NeighbouringPointsAreNoTrouble) {
  const double x = 1e15;
  const TransferFunction tf =
      on(ValueScale::kLog, with_opacities({{x, 0.25}, {std::nextafter(x, 2 * x), 0.75}}));
  EXPECT_EQ(tf.opacity_at(x), 0.25);
  EXPECT_EQ(tf.opacity_at(2 * x), 0.75);
}

TEST(ValueScale, MapRangeIsGeometricOnALogarithmicScale) {
  TransferFunction tf =
      on(ValueScale::kLog, with_opacities({{1, 0}, {10, 0.5}, {10, 0.75}, {100, 1}}));
  tf.colors = {{1, {0, 0, 0}}, {100, {1, 1, 1}}};
  tf.map_range(0.01, 1e6);
  EXPECT_EQ(tf.lo(), 0.01);
  EXPECT_EQ(tf.hi(), 1e6);
  EXPECT_NEAR(tf.opacities[1].x, 100, 1e-11);
  EXPECT_EQ(tf.opacities[1].x, tf.opacities[2].x);
  EXPECT_THROW(tf.map_range(0, 1), Error);
  EXPECT_THROW(tf.map_range(-1, 1), Error);
}

TEST(ValueScale, MapRangeSpreadsALinearMapOverDecades) {
  TransferFunction tf = with_colors({{0, {0, 0, 0}}, {0.5, {1, 0, 0}}, {1, {1, 1, 1}}});
  tf.map_range(1, 1e4, ValueScale::kLog);
  EXPECT_EQ(tf.scale, ValueScale::kLog);
  EXPECT_NEAR(tf.colors[1].x, 100, 1e-11);
  EXPECT_NEAR(tf.color_at(10)[0], 0.5, 1e-12);
  tf.map_range(-1000, 1000, ValueScale::kSymlog, 0.5);
  EXPECT_NEAR(tf.colors[1].x, 0, 1e-9);
  EXPECT_EQ(tf.linear_width, 0.5);
  EXPECT_THROW(tf.map_range(0, 1, ValueScale::kLog), Error);
  EXPECT_THROW(tf.map_range(0, 1, ValueScale::kSymlog, 0.0), Error);
  EXPECT_THROW(tf.map_range(0, 1, ValueScale::kSymlog, kNan), Error);
}

TEST(TransferFunction, ColoursBeyondTheEnds) {
  TransferFunction tf = with_colors({{0, {0, 0, 0}}, {2, {1, 1, 1}}});
  tf.below_color = Rgb{0, 0, 1};
  tf.above_color = Rgb{1, 0, 0};
  EXPECT_EQ(tf.color_at(0), (Rgb{0, 0, 0}));  // the ends themselves are within
  EXPECT_EQ(tf.color_at(2), (Rgb{1, 1, 1}));
  EXPECT_EQ(tf.color_at(std::nextafter(0.0, -1.0)), (Rgb{0, 0, 1}));
  EXPECT_EQ(tf.color_at(-kInfinity), (Rgb{0, 0, 1}));
  EXPECT_EQ(tf.color_at(std::nextafter(2.0, 3.0)), (Rgb{1, 0, 0}));
  tf.scale = ValueScale::kLog;
  tf.colors.front().x = 1;
  EXPECT_EQ(tf.color_at(-5), (Rgb{0, 0, 1}));
  tf.colors.clear();  // the gray ramp over [0, 1]
  EXPECT_EQ(tf.color_at(-0.1), (Rgb{0, 0, 1}));
  EXPECT_EQ(tf.color_at(0.5), (Rgb{0.5, 0.5, 0.5}));
  EXPECT_EQ(tf.color_at(1.1), (Rgb{1, 0, 0}));
}

// ---- color maps

TEST(ColorMap, EveryNameIsAMapOverZeroToOneAndReverses) {
  for (const std::string& name : color_map_names()) {
    const TransferFunction map = color_map(name);
    const TransferFunction reversed = color_map(name + "_r");
    EXPECT_EQ(map.name, name);
    EXPECT_TRUE(map.opacities.empty());
    EXPECT_EQ(map.lo(), 0.0);
    EXPECT_EQ(map.hi(), 1.0);
    EXPECT_EQ(reversed.lo(), 0.0);
    EXPECT_EQ(reversed.hi(), 1.0);
    const bool is_exact =
        map.color_space == ColorSpace::kRgb || map.color_space == ColorSpace::kStep;
    // Off the places where categories meet: there each side keeps its own.
    for (int i = 0; i <= 100; ++i) {
      const double x = i == 100 ? 1.0 : (i + 1.0 / 7) / 100;
      const Rgb there = map.color_at(x);
      const Rgb back = reversed.color_at(1 - x);
      for (int c = 0; c < 3; ++c) {
        EXPECT_GE(there[c], 0.0) << name;
        EXPECT_LE(there[c], 1.0) << name;
        // Rounding of 1 - x, times the steepest slope of a map (under 10); and as Lab returns for
        // cool-to-warm.
        EXPECT_NEAR(there[c], back[c], is_exact ? 1e-14 : 3e-3) << name << ' ' << i;
      }
    }
  }
}

// The published colours, entry `index` of 256, at the worst place of each map and at the quarters.
// The points reproduce them to half an 8-bit step.
TEST(ColorMap, ReproducesThePublishedTables) {
  constexpr double kTolerance = 1.0 / 512;
  struct Row {
    const char* name;
    int index;
    Rgb rgb;
  };
  const Row rows[] = {
      {"viridis", 64, {0.229739, 0.322361, 0.545706}},
      {"viridis", 128, {0.127568, 0.566949, 0.550556}},
      {"viridis", 192, {0.369214, 0.788888, 0.382914}},
      {"viridis", 191, {0.360741, 0.785964, 0.387814}},
      {"inferno", 64, {0.3415, 0.062325, 0.429425}},
      {"inferno", 128, {0.735683, 0.215906, 0.330245}},
      {"inferno", 192, {0.978422, 0.557937, 0.034931}},
      {"inferno", 61, {0.32261, 0.055634, 0.426377}},
      {"plasma", 64, {0.494877, 0.01199, 0.657865}},
      {"plasma", 128, {0.798216, 0.280197, 0.469538}},
      {"plasma", 192, {0.973416, 0.585761, 0.25154}},
      {"plasma", 254, {0.941896, 0.96859, 0.140956}},
      {"magma", 64, {0.316654, 0.07169, 0.48538}},
      {"magma", 128, {0.716387, 0.214982, 0.47529}},
      {"magma", 192, {0.9867, 0.535582, 0.38221}},
      {"magma", 16, {0.039608, 0.03109, 0.133515}},
      {"cividis", 64, {0.263738, 0.307831, 0.422789}},
      {"cividis", 128, {0.488697, 0.485318, 0.471008}},
      {"cividis", 192, {0.736488, 0.680629, 0.424028}},
      {"cividis", 248, {0.97778, 0.877281, 0.227954}},
      {"turbo", 64, {0.15844, 0.73551, 0.92305}},
      {"turbo", 128, {0.64362, 0.98999, 0.23356}},
      {"turbo", 192, {0.9836, 0.49291, 0.12849}},
      {"turbo", 197, {0.96904, 0.43399, 0.10294}},
  };
  for (const Row& row : rows) {
    const Rgb rgb = color_map(row.name).color_at(row.index / 255.0);
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(rgb[c], row.rgb[c], kTolerance) << row.name << ' ' << row.index;
  }
}

// The same for maps published to 8 bits: reproduced to one step (and to rounding of the two ends).
TEST(ColorMap, ReproducesThe8BitTables) {
  constexpr double kTolerance = 1.0 / 255 + 1e-6;
  struct Row {
    const char* name;
    int index;
    Rgb rgb;
  };
  const Row rows[] = {
      {"thermal", 64, {0.337255, 0.231373, 0.611765}},
      {"thermal", 130, {0.705882, 0.376471, 0.501961}},
      {"thermal", 192, {0.976471, 0.576471, 0.254902}},
      {"thermal", 8, {0.019608, 0.160784, 0.262745}},
      {"haline", 64, {0.058824, 0.356863, 0.564706}},
      {"haline", 130, {0.239216, 0.584314, 0.529412}},
      {"haline", 192, {0.478431, 0.796078, 0.403922}},
      {"haline", 14, {0.180392, 0.109804, 0.556863}},
      {"batlow", 64, {0.133333, 0.376471, 0.380392}},
      {"batlow", 130, {0.525490, 0.513725, 0.188235}},
      {"batlow", 192, {0.949020, 0.615686, 0.427451}},
      {"batlow", 60, {0.117647, 0.364706, 0.384314}},
      {"vik", 64, {0.188235, 0.490196, 0.650980}},
      {"vik", 130, {0.933333, 0.890196, 0.862745}},
      {"vik", 192, {0.760784, 0.439216, 0.254902}},
      {"vik", 39, {0.015686, 0.309804, 0.533333}},
      // Between coolwarm's 33 points, and those of fast, as VTK joins them in Lab.
      {"coolwarm", 64, {0.554312, 0.690097, 0.995516}},
      {"fast", 64, {0.321402, 0.636337, 0.900401}},
      {"fast", 191, {0.890876, 0.541467, 0.266892}},
  };
  for (const Row& row : rows) {
    const Rgb rgb = color_map(row.name).color_at(row.index / 255.0);
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(rgb[c], row.rgb[c], kTolerance) << row.name << ' ' << row.index;
  }
}

// Fails if a category is as wide as another, but for the two at the ends, or in another order.
TEST(ColorMap, CategoriesStandSideBySide) {
  const TransferFunction tab10 = color_map("tab10");
  const Rgb blue{31 / 255.0, 119 / 255.0, 180 / 255.0}, cyan{23 / 255.0, 190 / 255.0, 207 / 255.0};
  for (const double x : {-1.0, 0.0, 0.05, 0.0999}) EXPECT_EQ(tab10.color_at(x), blue) << x;
  EXPECT_NE(tab10.color_at(0.1001), blue);
  for (const double x : {0.9001, 0.95, 1.0, 2.0}) EXPECT_EQ(tab10.color_at(x), cyan) << x;
  EXPECT_EQ(color_map("tab10_r").color_at(0.05), cyan);
  for (const auto& [name, count] : {std::pair{"tab10", 10}, {"tab20", 20}, {"glasbey", 256}}) {
    const TransferFunction map = color_map(name);
    std::set<Rgb> colors;
    for (int i = 0; i < count; ++i) colors.insert(map.color_at((i + 0.5) / count));
    EXPECT_EQ(static_cast<int>(colors.size()), count) << name;
  }
}

TEST(Categorical, EveryValueHasTheNearestOnesColour) {
  const Rgb red{1, 0, 0}, green{0, 1, 0}, blue{0, 0, 1};
  const TransferFunction tf = categorical({10, 0, 4}, {red, green, blue});
  EXPECT_EQ(tf.color_at(-7), green);
  EXPECT_EQ(tf.color_at(1.9), green);
  EXPECT_EQ(tf.color_at(2.1), blue);
  EXPECT_EQ(tf.color_at(6.9), blue);
  EXPECT_EQ(tf.color_at(7.1), red);
  EXPECT_EQ(tf.color_at(10), red);
  EXPECT_EQ(categorical({0, 1, 2, 3}, {red, green}).color_at(2), red);  // colours repeat
  EXPECT_EQ(categorical({0, 0}, {red, green}).color_at(0), green);      // the last one counts
  EXPECT_THROW(categorical({}, {red}), Error);
  EXPECT_THROW(categorical({0}, {}), Error);
  EXPECT_THROW(categorical({0, kInfinity}, {red}), Error);
}

TEST(ColorMap, CoolToWarmIsGrayInTheMiddle) {
  const TransferFunction map = color_map("cool-to-warm");
  EXPECT_EQ(map.color_space, ColorSpace::kDiverging);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(map.color_at(0.5)[c], 0.865, 3e-3);
}

TEST(ColorMap, AnUnknownNameListsTheKnownOnes) {
  for (const char* name : {"vridis", "_r", "", "viridis_r_r"}) {
    try {
      color_map(name);
      FAIL() << name;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
      EXPECT_NE(std::string(error.what()).find("inferno"), std::string::npos);
    }
  }
}

// A quotient of value and width beyond the range of double must not make the curves NaN.
TEST(ValueScale, SymmetricLogarithmsOfExtremesAreFinite) {
  TransferFunction tf;
  tf.scale = ValueScale::kSymlog;
  tf.linear_width = 1e-300;
  tf.opacities = {{-1e308, 0}, {5, 1}};
  double before = 0;
  for (const double value : {-1e308, -5e307, -1.0, 0.0, 1.0, 5.0}) {
    const double opacity = tf.opacity_at(value);
    EXPECT_GE(opacity, before) << value;
    EXPECT_LE(opacity, 1.0) << value;
    before = opacity;
  }
  EXPECT_EQ(before, 1.0);
}

}  // namespace transfer_function_test
}  // namespace ovoid
