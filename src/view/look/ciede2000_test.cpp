// SPDX-License-Identifier: Apache-2.0
#include "view/look/ciede2000.h"

#include <gtest/gtest.h>

#include <cmath>

#include "ovoid/error.h"

namespace ovoid::view {
namespace ciede2000_test {

// Pairs of the test data published with [Sharma 2005], differences to four digits: around the gray
// axis, hues a half circle apart on either side, and the blues where the rotation term works.
TEST(Ciede2000, PublishedDifferences) {
  struct Row {
    Rgb a, b;
    double difference;
  };
  const Row rows[] = {
      {{50, 2.6772, -79.7751}, {50, 0, -82.7485}, 2.0425},
      {{50, -1.3802, -84.2814}, {50, 0, -82.7485}, 1.0000},
      {{50, 0, 0}, {50, -1, 2}, 2.3669},
      {{50, 2.49, -0.001}, {50, -2.49, 0.0009}, 7.1792},
      {{50, 2.49, -0.001}, {50, -2.49, 0.0011}, 7.2195},
      {{50, 2.5, 0}, {50, 0, -2.5}, 4.3065},
      {{50, 2.5, 0}, {73, 25, -18}, 27.1492},
      {{50, 2.5, 0}, {61, -5, 29}, 22.8977},
      {{60.2574, -34.0099, 36.2677}, {60.4626, -34.1751, 39.4387}, 1.2644},
      {{22.7233, 20.0904, -46.694}, {23.0331, 14.973, -42.5619}, 2.0373},
      {{90.8027, -2.0831, 1.441}, {91.1528, -1.6435, 0.0447}, 1.4441},
      {{2.0776, 0.0795, -1.135}, {0.9033, -0.0636, -0.5514}, 0.9082},
  };
  for (const Row& row : rows) {
    EXPECT_NEAR(ciede2000(row.a, row.b), row.difference, 5e-5) << row.difference;
    EXPECT_NEAR(ciede2000(row.b, row.a), row.difference, 5e-5) << row.difference;
  }
}

// vtkColorTransferFunction 9.1 in the space Lab/CIEDE2000, which rounds to 8 bits; between points
// whose grid colours differ, and within one of the grid's cells.
TEST(Ciede2000, ColoursAsVtk) {
  struct Row {
    Rgb a, b;
    double s;
    Rgb expected;
  };
  const Rgb red{1, 0, 0}, blue{0, 0, 1}, green{0.1, 0.6, 0.2}, brown{0.6, 0.3, 0.1};
  const Row rows[] = {
      {red, blue, 0.02, {1.000000, 0.000000, 0.054902}},
      {red, blue, 0.05, {1.000000, 0.000000, 0.113725}},
      {red, blue, 0.25, {0.886275, 0.113725, 0.301961}},
      {red, blue, 0.5, {0.768627, 0.062745, 0.482353}},
      {red, blue, 0.75, {0.568627, 0.062745, 0.682353}},
      {red, blue, 0.9, {0.388235, 0.062745, 0.862745}},
      {green, brown, 0.1, {0.325490, 0.615686, 0.188235}},
      {green, brown, 0.4, {0.450980, 0.486275, 0.200000}},
      {green, brown, 0.6, {0.501961, 0.435294, 0.247059}},
      {green, brown, 0.9, {0.588235, 0.352941, 0.160784}},
  };
  for (const Row& row : rows) {
    TransferFunction tf;
    tf.colors = {{-5, row.a}, {15, row.b}};
    follow_ciede2000(tf);
    EXPECT_EQ(tf.color_space, ColorSpace::kLab);
    const Rgb rgb = tf.color_at(-5 + 20 * row.s);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(rgb[c], row.expected[c], 1.0 / 255) << row.s;
    tf.colors = {{1, row.a}, {1e4, row.b}};
    tf.color_space = ColorSpace::kRgb;
    tf.scale = ValueScale::kLog;
    follow_ciede2000(tf);
    const Rgb there = tf.color_at(std::pow(10, 4 * row.s));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(there[c], row.expected[c], 1.0 / 255) << row.s;
  }
}

TEST(Ciede2000, PointsKeepTheirOrderAndSteps) {
  TransferFunction tf;
  tf.colors = {{0, {1, 0, 0}}, {1, {0, 0, 1}}, {1, {0, 1, 0}}, {2, {0, 1, 0.01}}, {3, {1, 1, 1}}};
  follow_ciede2000(tf);
  EXPECT_EQ(tf.lo(), 0.0);
  EXPECT_EQ(tf.hi(), 3.0);
  for (std::size_t i = 1; i < tf.colors.size(); ++i) {
    EXPECT_LE(tf.colors[i - 1].x, tf.colors[i].x) << i;
  }
  EXPECT_NEAR(tf.color_at(std::nextafter(1.0, 0.0))[2], 1.0, 3e-3);
  EXPECT_NEAR(tf.color_at(1)[1], 1.0, 3e-3);
  EXPECT_NEAR(tf.color_at(1)[2], 0.0, 3e-3);
}

TEST(Ciede2000, ManyPointsAreRefused) {
  TransferFunction tf;
  tf.colors.assign(kMaxCiede2000Points + 1, {});
  try {
    follow_ciede2000(tf);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUnsupported);
  }
  TransferFunction empty;
  follow_ciede2000(empty);
  EXPECT_TRUE(empty.colors.empty());
}

}  // namespace ciede2000_test
}  // namespace ovoid::view
