// SPDX-License-Identifier: Apache-2.0
#include "view/look/look_table.h"
#include "support/where.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>

#include "ovoid/look.h"
#include "support/numbers.h"

namespace ovoid::view {
namespace look_table_test {

TransferFunction hat(double foot, double peak, double end, double low = 0.0, double high = 1.0) {
  TransferFunction tf;
  tf.opacities = {{foot, low}, {peak, high}, {end, low}};
  return tf;
}

double cell_of(const LookTable& table) {
  return 1.0 / static_cast<double>(table.axis().cells_per_step);
}

// Random curves with plateaus of zero, steps, bent segments and ends of every kind; points at
// multiples of 1/8, floats.
TransferFunction random_function(std::mt19937_64& random) {
  const auto uniform = [&] { return std::uniform_real_distribution<double>(0.0, 1.0)(random); };
  TransferFunction tf;
  double x = std::floor(1000 * uniform()) - 500;
  const int num_points = 1 + static_cast<int>(8 * uniform());
  for (int i = 0; i < num_points; ++i) {
    const double kind = uniform();
    tf.opacities.push_back({x, uniform() < 0.5 ? 0.0 : uniform(), 0.5, 0.0});
    if (kind < 0.2) tf.opacities.back().midpoint = std::round(4 * uniform()) / 4;
    if (kind < 0.4) tf.opacities.back().sharpness = std::round(4 * uniform()) / 4;
    if (uniform() > 0.15) x += std::ceil(400 * uniform()) / 8;
  }
  if (uniform() < 0.7)
    tf.colors = {{x - 300, {0, 0.5, 1}}, {x - 60, {0.25, 0.25, 0.25}}, {x + 50, {1, 0.5, 0}}};
  return tf;
}

// The least and greatest exact opacity over [lo, hi]: every segment is monotonic, so ends and
// points decide.
struct Extent {
  double least, greatest;
};

Extent exact_opacity(const TransferFunction& tf, double lo, double hi) {
  Extent out{tf.opacity_at(lo), tf.opacity_at(lo)};
  const auto take = [&](double opacity) {
    out.least = std::min(out.least, opacity);
    out.greatest = std::max(out.greatest, opacity);
  };
  take(tf.opacity_at(hi));
  for (const OpacityPoint& p : tf.opacities) {
    if (p.x > lo && p.x <= hi) take(p.opacity);
  }
  return out;
}

// Fails if entries are evaluated at other values than readers compute, if the table is not padded,
// or if a range is cut.
TEST(LookTable, StraightPiecesAreExactToFloatRounding) {
  OVOID_NOT_UNDER_TSAN();
  TransferFunction tf;
  tf.opacities = {{-10, 0.25}, {30, 0.75}};
  tf.colors = {{-10, {0, 1, 0.5}}, {30, {1, 0, 0.5}}};
  const LookTable table(tf);
  for (double v = -10; v <= 30; v += 1.0 / 64) {
    const auto s = table.at(static_cast<float>(v));
    // A coordinate of 4096 is rounded twice, to 2^-12 cells: 6e-8 of a curve that rises by 1; three
    // roundings of values up to 1, 2^-24 each; and at -10, a corner, the 1/512 cells to the next
    // entry: 4.8e-7.
    const double tolerance = 8e-7;
    ASSERT_NEAR(s.opacity, tf.opacity_at(v), tolerance) << v;
    ASSERT_NEAR(s.r, tf.color_at(v)[0], tolerance) << v;
    ASSERT_NEAR(s.g, tf.color_at(v)[1], tolerance) << v;
    ASSERT_NEAR(s.b, tf.color_at(v)[2], tolerance) << v;
  }
  EXPECT_EQ(table.at(kInfinityF).opacity, 0.75F);
  EXPECT_EQ(table.at(-kInfinityF).opacity, 0.25F);
  EXPECT_EQ(table.at(1e30F).r, 1.0F);
}

TEST(LookTable, ArraysAreAlignedAndPadded) {
  OVOID_NOT_UNDER_TSAN();
  const LookTable table(hat(0, 1, 2, 0.1, 0.9));
  for (const float* x : {table.red(), table.green(), table.blue(), table.opacity()}) {
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(x) % 64, 0U);
    for (int i = LookTable::kEntries; i < LookTable::kPaddedEntries; ++i)
      EXPECT_EQ(x[i], x[LookTable::kCells]);
  }
}

TEST(LookTable, CornersErrByAQuarterOfTheSlopesDifference) {
  OVOID_NOT_UNDER_TSAN();
  const TransferFunction tf = hat(0, 17.3, 100, 0.1, 0.9);
  const LookTable table(tf);
  const double slopes = 0.8 / 17.3 + 0.8 / 82.7;
  double worst = 0;
  for (int i = 0; i <= 200000; ++i) {
    const auto v = static_cast<float>(i * 0.0005);
    worst = std::max(worst, std::abs(static_cast<double>(table.at(v).opacity) - tf.opacity_at(v)));
  }
  EXPECT_LE(worst, 0.25 * slopes * cell_of(table) + 3e-7);
}

// A peak 2 % of the range wide gets all the cells. Where it leaves zero it may start a cell late:
// one cell's rise.
TEST(LookTable, NarrowPeaksHaveAllTheCells) {
  OVOID_NOT_UNDER_TSAN();
  TransferFunction tf = hat(98, 100, 102);
  tf.colors = {{0, {0, 0, 0}}, {200, {1, 1, 1}}};
  const LookTable table(tf);
  EXPECT_NEAR(cell_of(table), 4.0 / 4094, 1e-5);
  double worst = 0;
  for (int i = 0; i <= 100000; ++i) {
    const auto v = static_cast<float>(97 + i * 6e-5);
    worst = std::max(worst, std::abs(static_cast<double>(table.at(v).opacity) - tf.opacity_at(v)));
  }
  EXPECT_LE(worst, 0.5 * cell_of(table));
  EXPECT_EQ(table.at(97).opacity, 0.0F);
  EXPECT_EQ(table.at(150).opacity, 0.0F);
  EXPECT_NEAR(table.at(101).r, 0.505, 1e-6);
}

// Fails if a step is taken anywhere but at its value, from either curve.
TEST(LookTable, StepsAreWhereTheyShouldBe) {
  OVOID_NOT_UNDER_TSAN();
  TransferFunction tf;
  tf.opacities = {{0, 0.125}, {33.3, 0.125}, {33.3, 0.75}, {60, 0.75, 0.5, 1}, {80, 0.25}};
  tf.colors = {{0, {1, 0, 0}}, {50, {0, 1, 0}}, {100, {0, 0, 1}}};
  tf.color_space = ColorSpace::kStep;
  const LookTable table(tf);
  ASSERT_TRUE(table.has_steps());
  // A coordinate of some thousand cells is rounded to 2^-12 cells, here 6e-6.
  const float near = 1e-5F;
  EXPECT_EQ(table.at(33.3F - near).opacity, 0.125F);
  EXPECT_EQ(table.at(33.3F + near).opacity, 0.75F);
  EXPECT_EQ(table.at(70 - near).opacity, 0.75F);
  EXPECT_EQ(table.at(70 + near).opacity, 0.25F);
  EXPECT_EQ(table.at(50 - near).g, 1.0F);
  EXPECT_EQ(table.at(50 + near).b, 1.0F);
}

// Fails if an entry that a step falls on is read from the wrong side: one of the many does.
TEST(LookTable, EveryPlaceOfAStepIsSharp) {
  OVOID_NOT_UNDER_TSAN();
  for (int trial = 0; trial < 5000; ++trial) {
    const double x = 10 + trial * 0.001;
    TransferFunction tf;
    tf.opacities = {{0, 0.5}, {x, 0.5}, {x, 1}, {20, 1}};
    const LookTable table(tf);
    const float near = 3e-6F;  // as above, for a fifth of the span
    ASSERT_EQ(table.at(static_cast<float>(x) - near).opacity, 0.5F) << x;
    ASSERT_EQ(table.at(static_cast<float>(x) + near).opacity, 1.0F) << x;
  }
}

TEST(LookTable, SmoothCurvesHaveNoSteps) {
  OVOID_NOT_UNDER_TSAN();
  EXPECT_FALSE(LookTable(hat(0, 1, 2)).has_steps());
}

// Steps at the very ends of the points must not spoil the endless ranges beyond them.
TEST(LookTable, StepsAtTheEnds) {
  OVOID_NOT_UNDER_TSAN();
  TransferFunction tf;
  tf.opacities = {{0, 0}, {0, 1}, {10, 1}, {10, 0.25}};
  const LookTable table(tf);
  EXPECT_EQ(table.at(-1).opacity, 0.0F);
  EXPECT_EQ(table.at(-1e9F).opacity, 0.0F);
  EXPECT_EQ(table.at(5).opacity, 1.0F);
  EXPECT_EQ(table.at(11).opacity, 0.25F);
  EXPECT_EQ(table.at(1e9F).opacity, 0.25F);
}

// At every value the table must lie within what the curve does up to two cells away (one for a
// step, one for a late start); colours are straight, so they agree where they are kept. Fails for
// any misplaced entry.
TEST(LookTable, RandomCurvesStayWithinTwoCells) {
  OVOID_NOT_UNDER_TSAN();
  std::mt19937_64 random(20240601);
  for (int trial = 0; trial < 300; ++trial) {
    const TransferFunction tf = random_function(random);
    const LookTable table(tf);
    const double reach = 2 * cell_of(table);
    const double lo = tf.lo() - 10, hi = tf.hi() + 10;
    for (int i = 0; i <= 500; ++i) {
      const auto v = static_cast<float>(lo + (hi - lo) * i / 500);
      const Extent near = exact_opacity(tf, v - reach, v + reach);
      const double opacity = table.at(v).opacity;
      ASSERT_GE(opacity, near.least - 3e-7) << "trial " << trial << " at " << v;
      ASSERT_LE(opacity, near.greatest + 3e-7) << "trial " << trial << " at " << v;
    }
  }
}

// ---- any_opacity

TEST(LookTable, TheFootOfARampIsExactlyZero) {
  OVOID_NOT_UNDER_TSAN();
  // Background at 0, 40 or -1000 must stay free, at the low end of the points and in their middle.
  TransferFunction tf;
  tf.opacities = {{0, 0}, {40, 0}, {80, 1}, {90, 0}, {255, 0}};
  const LookTable table(tf);
  EXPECT_EQ(table.at(0).opacity, 0.0F);
  EXPECT_EQ(table.at(40).opacity, 0.0F);
  EXPECT_EQ(table.at(90).opacity, 0.0F);
  EXPECT_FALSE(table.any_opacity(0, 40));
  EXPECT_FALSE(table.any_opacity(90, 255));
  EXPECT_TRUE(table.any_opacity(0, std::nextafter(40.0F, 41.0F)));
  EXPECT_TRUE(table.any_opacity(std::nextafter(90.0F, 89.0F), 255));
  EXPECT_TRUE(table.any_opacity(0, 255));
  EXPECT_FALSE(table.any_opacity(41, 40));

  const LookTable whole(ramp_look({0.0F, 255.0F}).transfer_function);
  EXPECT_FALSE(whole.any_opacity(0, 0));
  EXPECT_FALSE(whole.any_opacity(-kInfinityF, 0));
  EXPECT_TRUE(whole.any_opacity(0, 1e-3F));

  // Colours that reach below the background, and a foot that no entry meets.
  TransferFunction shifted = hat(-1000, 1000, 3000.7);
  shifted.colors = {{-1024, {0, 0, 0}}, {3071, {1, 1, 1}}};
  const LookTable ct(shifted);
  EXPECT_FALSE(ct.any_opacity(-1024, -1000));
  EXPECT_FALSE(ct.any_opacity(3000.75F, 5000));
  EXPECT_TRUE(ct.any_opacity(-1024, -999));
}

// Fails if a skipped value could have shown in the table or exactly, or if ranges two cells away
// from anything are drawn.
TEST(LookTable, AnyOpacityIsNeverWronglyFalseAndSeldomWronglyTrue) {
  OVOID_NOT_UNDER_TSAN();
  std::mt19937_64 random(42);
  const auto uniform = [&] { return std::uniform_real_distribution<double>(0.0, 1.0)(random); };
  int num_false = 0, num_true = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const TransferFunction tf = random_function(random);
    const LookTable table(tf);
    const double reach = 2.01 * cell_of(table);
    // Strongly bent segments run into zero so smoothly that evaluation rounds to 0 over many cells;
    // true is right there.
    const bool is_flat_at_ends =
        std::any_of(tf.opacities.begin(), tf.opacities.end(),
                    [](const OpacityPoint& p) { return p.sharpness > 0.3 && p.sharpness < 0.99; });
    for (int query = 0; query < 20; ++query) {
      // Ends anywhere, on a point, or a float beside one; ranges from one value to everything.
      const auto end = [&] {
        const double v = tf.lo() - 5 + (tf.hi() - tf.lo() + 10) * uniform();
        const auto x = static_cast<float>(tf.opacities[random() % tf.opacities.size()].x);
        switch (random() % 5) {
          case 0:
            return x;
          case 1:
            return std::nextafter(x, kInfinityF);
          case 2:
            return std::nextafter(x, -kInfinityF);
          default:
            return static_cast<float>(v);
        }
      };
      float lo = end(), hi = random() % 4 == 0 ? lo : end();
      if (lo > hi) std::swap(lo, hi);
      double table_most = 0;
      for (int i = 0; i <= 64; ++i) {
        const float v = i == 64 ? hi : lo + (hi - lo) * (static_cast<float>(i) / 64);
        table_most = std::max(table_most, static_cast<double>(table.at(v).opacity));
      }
      bool shows = table_most > 0 || tf.opacity_at(lo) > 0 || tf.opacity_at(hi) > 0;
      for (const OpacityPoint& p : tf.opacities) {
        const auto x = static_cast<float>(p.x);
        for (const float v : {std::nextafter(x, -kInfinityF), x, std::nextafter(x, kInfinityF)}) {
          shows =
              shows || (v >= lo && v <= hi && (tf.opacity_at(v) > 0 || table.at(v).opacity > 0));
        }
      }
      const bool shows_near = exact_opacity(tf, lo - reach, hi + reach).greatest > 0;
      const bool answer = table.any_opacity(lo, hi);
      ASSERT_TRUE(answer || !shows) << "trial " << trial << ": [" << lo << ", " << hi << "]";
      ASSERT_TRUE(!answer || shows_near || is_flat_at_ends)
          << "trial " << trial << ": [" << lo << ", " << hi << "]";
      ++(answer ? num_true : num_false);
    }
  }
  EXPECT_GT(num_false, 5000);  // the draw reaches both answers
  EXPECT_GT(num_true, 5000);
}

// A label of width 1 among 65536, and steps by sharpness with their midpoint off the middle.
TEST(LookTable, StepsBySharpnessCountFromTheirMidpoint) {
  OVOID_NOT_UNDER_TSAN();
  TransferFunction tf;
  tf.opacities = {{0, 0, 0.25, 1}, {100, 1, 0.75, 1}, {200, 0}};  // one from 25 to 175
  tf.colors = {{0, {0, 0, 0}}, {65535, {1, 1, 1}}};
  const LookTable table(tf);
  const auto cell = static_cast<float>(1.01 * cell_of(table));
  EXPECT_FALSE(table.any_opacity(0, 25 - cell));
  EXPECT_FALSE(table.any_opacity(175 + cell, 65535));
  EXPECT_TRUE(table.any_opacity(0, 25));
  EXPECT_TRUE(table.any_opacity(std::nextafter(175.0F, 0.0F), 65535));
  for (const double midpoint : {0.0, 1.0}) {  // a midpoint at the end acts 1e-5 inside
    tf.opacities = {{0, 1, midpoint, 1}, {100, 0}};
    const LookTable falling(tf);
    EXPECT_TRUE(falling.any_opacity(0.0005F, 0.0005F));
    EXPECT_EQ(falling.any_opacity(99, 200), midpoint == 1.0);
  }
}

// Fails if the exact curve is not asked: all of this lies within one cell of the table, which reads
// zero there.
TEST(LookTable, FeaturesNarrowerThanACellAreNotDenied) {
  OVOID_NOT_UNDER_TSAN();
  TransferFunction tf;
  tf.opacities = {{0, 0},       {1, 1},    {2, 0},    {1000, 0}, {1000.01, 0.5},
                  {1000.02, 0}, {5000, 0}, {5001, 1}, {5002, 0}};
  const LookTable table(tf);
  EXPECT_TRUE(table.any_opacity(999, 1001));
  EXPECT_TRUE(table.any_opacity(1000.01F, 1000.01F));
  EXPECT_FALSE(table.any_opacity(100, 1000));
  EXPECT_FALSE(table.any_opacity(1000.03F, 4999));
}

TEST(LookTable, MaxOpacity) {
  OVOID_NOT_UNDER_TSAN();
  EXPECT_EQ(LookTable(hat(0, 1, 2, 0.125, 0.75)).max_opacity(), 0.75F);
  EXPECT_EQ(LookTable(TransferFunction()).max_opacity(), 1.0F);
  EXPECT_TRUE(LookTable(TransferFunction()).any_opacity(5, 5));
  TransferFunction nothing;
  nothing.opacities = {{0, 0}, {1, 0}};
  EXPECT_EQ(LookTable(nothing).max_opacity(), 0.0F);
  EXPECT_FALSE(LookTable(nothing).any_opacity(-kInfinityF, kInfinityF));
}

// Six decades: every one of them has its cells. Fails if entries stand at other values than readers
// compute, or if a corner's place is taken for linear.
TEST(LookTable, LogarithmicScalesResolveEveryDecade) {
  OVOID_NOT_UNDER_TSAN();
  TransferFunction tf;
  tf.scale = ValueScale::kLog;
  tf.opacities = {{1e-6, 0}, {1e-5, 0.4}, {1e-2, 0.1, 0.3, 0.5}, {1, 0.9}};
  tf.colors = {{1e-6, {0, 0, 0}}, {1e-3, {1, 0.5, 0}}, {1, {1, 1, 1}}};
  const LookTable table(tf);
  // A cell is 20 octaves / 4094; the steepest slopes meet at 1e-5: 0.4 and 0.1 per decade.
  const double cell_in_decades = 6.0 / 4094;
  for (double e = -6.5; e <= 0.5; e += 1e-3) {
    const double v = std::pow(10.0, e);
    const auto s = table.at(static_cast<float>(v));
    ASSERT_NEAR(s.opacity, tf.opacity_at(v), 1.0 * cell_in_decades) << v;
    ASSERT_NEAR(s.r, tf.color_at(v)[0], 0.3 * cell_in_decades) << v;
    ASSERT_NEAR(s.g, tf.color_at(v)[1], 0.3 * cell_in_decades) << v;
  }
  for (const float nothing : {0.0F, -1.0F, -kInfinityF, 5e-7F}) {
    EXPECT_EQ(table.at(nothing).opacity, 0.0F) << nothing;
    EXPECT_FALSE(table.any_opacity(-kInfinityF, nothing)) << nothing;
  }
  EXPECT_TRUE(table.any_opacity(2e-6F, 3e-6F));
}

TEST(LookTable, SymmetricLogarithmsGoThroughZero) {
  OVOID_NOT_UNDER_TSAN();
  TransferFunction tf;
  tf.scale = ValueScale::kSymlog;
  tf.linear_width = 1e-3;
  tf.opacities = {{-100, 0.8}, {-1, 0.2}, {0, 0}, {1e-2, 0.5}, {100, 1}};
  tf.colors = {{-100, {0, 0, 1}}, {100, {1, 0, 0}}};
  const LookTable table(tf);
  const double cell = 10.0 / 4094;  // decades, both sides together
  for (double e = -6; e <= 2; e += 1e-3) {
    for (const double v : {std::pow(10.0, e), -std::pow(10.0, e)}) {
      const auto s = table.at(static_cast<float>(v));
      ASSERT_NEAR(s.opacity, tf.opacity_at(v), cell) << v;
      ASSERT_NEAR(s.b, tf.color_at(v)[2], 0.3 * cell) << v;
    }
  }
}

TEST(LookTable, ColoursBeyondTheEndsBeginThere) {
  OVOID_NOT_UNDER_TSAN();
  TransferFunction tf;
  tf.opacities = {{-10, 0.5}, {20, 0.5}};
  tf.colors = {{0, {0, 1, 0}}, {10, {0, 0, 1}}};
  tf.below_color = Rgb{1, 0, 0};
  tf.above_color = Rgb{1, 1, 1};
  const LookTable table(tf);
  EXPECT_EQ(table.at(-1e-3F).r, 1.0F);
  EXPECT_EQ(table.at(1e-3F).r, 0.0F);
  EXPECT_NEAR(table.at(1e-3F).g, 1.0F, 1e-3F);
  EXPECT_EQ(table.at(10.0F - 1e-3F).r, 0.0F);
  EXPECT_EQ(table.at(10.0F + 1e-3F).r, 1.0F);
}

// Spans that single precision cannot divide, single places, and values beyond its range. Fails if
// anything is not a number, or if values that float can tell apart from the step read the wrong
// side.
TEST(LookTable, ExtremeRanges) {
  OVOID_NOT_UNDER_TSAN();
  const double spans[][2] = {{1e6, 1e6 + 1e-3}, {0, 1e-40},     {-1e300, 1e300},     {5, 5}, {0, 0},
                             {-1e-30, 1e-30},   {1e30, 1.1e30}, {16777216, 16777226}};
  for (const auto& [lo, hi] : spans) {
    TransferFunction tf;
    tf.opacities = {{lo, 0.25}, {lo, 0.5}, {hi, 0.5}, {hi, 0.75}};
    tf.colors = {{lo, {0, 0, 0}}, {hi, {1, 1, 1}}};
    const LookTable table(tf);
    EXPECT_TRUE(std::isfinite(table.axis().origin) && std::isfinite(table.axis().cells_per_step) &&
                table.axis().cells_per_step > 0)
        << lo;
    for (const double v : {lo, 0.5 * lo + 0.5 * hi, hi, 0.0, 1.0}) {
      const auto s = table.at(static_cast<float>(v));
      EXPECT_TRUE(s.opacity >= 0.25F && s.opacity <= 0.75F) << lo << ' ' << v;
      EXPECT_TRUE(s.r >= 0 && s.r <= 1) << lo << ' ' << v;
    }
    if (std::abs(lo) > 1e38) continue;
    const double beside =
        std::max(1e-6 * std::max(std::abs(lo), std::abs(hi)), 1e-3 * (hi - lo)) + 1e-30;
    const auto below = static_cast<float>(lo - beside);
    const auto above = static_cast<float>(hi + beside);
    EXPECT_EQ(table.at(below).opacity, 0.25F) << lo;
    EXPECT_EQ(table.at(above).opacity, 0.75F) << lo;
  }
}

}  // namespace look_table_test
}  // namespace ovoid::view
