// SPDX-License-Identifier: Apache-2.0
#include "view/look/color_spaces.h"

#include <gtest/gtest.h>

#include <cmath>

namespace ovoid::view {
namespace color_spaces_test {

void expect_near(const Rgb& actual, const Rgb& expected, double tolerance) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(actual[c], expected[c], tolerance) << "component " << c;
}

constexpr Rgb kRed{1, 0, 0}, kGreen{0, 1, 0}, kBlue{0, 0, 1}, kWhite{1, 1, 1}, kBlack{0, 0, 0};

// Exact by construction but for a rounding or two of numbers up to 6.
constexpr double kRounding = 1e-15;

TEST(ColorSpaces, HsvOfThePrimaries) {
  expect_near(hsv_from_rgb(kRed), {0, 1, 1}, 0);
  expect_near(hsv_from_rgb(kGreen), {1.0 / 3, 1, 1}, kRounding);
  expect_near(hsv_from_rgb(kBlue), {2.0 / 3, 1, 1}, kRounding);
  expect_near(hsv_from_rgb({0.5, 0.25, 0.5}), {5.0 / 6, 0.5, 0.5}, kRounding);  // a dull magenta
  expect_near(hsv_from_rgb({0.25, 0.25, 0.25}), {0, 0, 0.25}, 0);
  expect_near(hsv_from_rgb(kBlack), {0, 0, 0}, 0);
}

// Fails if a sextant of either direction is wrong.
TEST(ColorSpaces, HsvReturns) {
  for (double r = 0; r <= 1; r += 0.125) {
    for (double g = 0; g <= 1; g += 0.125) {
      for (double b = 0; b <= 1; b += 0.125)
        expect_near(rgb_from_hsv(hsv_from_rgb({r, g, b})), {r, g, b}, 2 * kRounding);
    }
  }
}

// Published: L* of white is 100, of the sRGB red 53.24 with a* 80.09, b* 67.20 (D65, two digits;
// the four-digit matrices move them by under 0.03).
TEST(ColorSpaces, LabOfKnownColours) {
  expect_near(lab_from_rgb(kWhite), {100, 0, 0}, 0.03);
  expect_near(lab_from_rgb(kRed), {53.24, 80.09, 67.20}, 0.03);
  expect_near(lab_from_rgb(kBlue), {32.30, 79.19, -107.86}, 0.03);
  expect_near(lab_from_rgb(kBlack), {0, 0, 0}, 1e-12);
  // The 18 % gray card: L* = 116 cbrt(0.184187) - 16 = 50.00 at linear 0.184187, sRGB 0.46633.
  expect_near(lab_from_rgb({0.46633, 0.46633, 0.46633}), {50, 0, 0}, 0.03);
}

// The product of the two four-digit matrices is the identity to 3e-4, which the steep foot of the
// sRGB curve (12.92) and the clipping to the gamut raise to 3e-3.
TEST(ColorSpaces, LabReturnsToThreeThousandths) {
  for (double r = 0; r <= 1; r += 0.125) {
    for (double g = 0; g <= 1; g += 0.125) {
      for (double b = 0; b <= 1; b += 0.125)
        expect_near(rgb_from_lab(lab_from_rgb({r, g, b})), {r, g, b}, 3e-3);
    }
  }
}

TEST(ColorSpaces, LabOutsideTheGamutIsBroughtIn) {
  for (const Rgb& lab : {Rgb{150, 0, 0}, Rgb{50, 200, 0}, Rgb{50, -200, 200}, Rgb{-10, 0, 0}}) {
    for (const double v : rgb_from_lab(lab)) {
      EXPECT_GE(v, 0.0);
      EXPECT_LE(v, 1.0);
    }
  }
}

// Blue to red through green is the rainbow that presets mean by HSV; with the hue wrapped it goes
// through magenta.
TEST(ColorSpaces, HsvTakesTheLongWayUnlessWrapped) {
  expect_near(interpolate(ColorSpace::kHsv, kBlue, kRed, 0.5), kGreen, 4 * kRounding);
  expect_near(interpolate(ColorSpace::kHsvWrap, kBlue, kRed, 0.5), {1, 0, 1}, 4 * kRounding);
  expect_near(interpolate(ColorSpace::kHsvWrap, kRed, kBlue, 0.5), {1, 0, 1}, 4 * kRounding);
  expect_near(interpolate(ColorSpace::kHsvWrap, kRed, kGreen, 0.5), {1, 1, 0}, 4 * kRounding);
}

// [Moreland 2009]: between his blue and his red lies the gray of magnitude 88, (0.865, 0.865,
// 0.865).
TEST(ColorSpaces, DivergingMeetsInWhite) {
  const Rgb blue{0.230, 0.299, 0.754}, red{0.706, 0.016, 0.150};
  expect_near(interpolate(ColorSpace::kDiverging, blue, red, 0.5), {0.865, 0.865, 0.865},
              5e-4);  // three digits given
  expect_near(interpolate(ColorSpace::kDiverging, blue, red, 0.0), blue, 3e-3);  // as Lab returns
  expect_near(interpolate(ColorSpace::kDiverging, blue, red, 1.0), red, 3e-3);
  // Brighter ends raise the meeting point: it is never darker than either.
  const Rgb middle = interpolate(ColorSpace::kDiverging, {1, 1, 0}, {0, 1, 1}, 0.5);
  EXPECT_GT(middle[1], 0.95);
}

// Colours from VTK 9.1 for the same calls, to six digits: between equal hues, from gray to a colour
// (the hue spins), from a colour to black, and on both sides of the middle.
TEST(ColorSpaces, DivergingAsVtk) {
  struct Row {
    Rgb a, b;
    double s;
    Rgb expected;
  };
  const Row rows[] = {
      {{0.2, 0.3, 0.8}, {0.1, 0.1, 0.5}, 0.5, {0.141903, 0.192027, 0.643498}},
      {{0.5, 0.5, 0.5}, {0.7, 0.1, 0.2}, 0.3, {0.667151, 0.496014, 0.488495}},
      {{0.9, 0.9, 0.9}, {0.1, 0.5, 0.2}, 0.5, {0.431612, 0.781066, 0.660695}},
      {{0.8, 0.2, 0.6}, {0, 0, 0}, 0.5, {0.452987, 0.308159, 0.390267}},
      {{0.1, 0.6, 0.2}, {0.8, 0.3, 0.1}, 0.25, {0.606368, 0.829519, 0.595421}},
      {{0.1, 0.6, 0.2}, {0.8, 0.3, 0.1}, 0.75, {0.992815, 0.681419, 0.522969}},
      {{0.9, 0.95, 1}, {0.2, 0.1, 0.4}, 0.4, {0.482032, 0.646261, 0.930355}},
      {{1, 1, 1}, {0.5, 0.1, 0.9}, 0.6, {0.795998, 0.562474, 1.000000}},
  };
  for (const Row& row : rows) {
    expect_near(interpolate(ColorSpace::kDiverging, row.a, row.b, row.s), row.expected, 1e-6);
  }
}

TEST(ColorSpaces, StepIsTheSecondColour) {
  EXPECT_EQ(interpolate(ColorSpace::kStep, kRed, kBlue, 0.0), kRed);
  EXPECT_EQ(interpolate(ColorSpace::kStep, kRed, kBlue, 1e-9), kBlue);
  EXPECT_EQ(interpolate(ColorSpace::kStep, kRed, kBlue, 1.0), kBlue);
}

}  // namespace color_spaces_test
}  // namespace ovoid::view
