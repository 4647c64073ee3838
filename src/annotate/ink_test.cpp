// SPDX-License-Identifier: Apache-2.0
#include "annotate/ink.h"

#include <gtest/gtest.h>

#include <array>

namespace ovoid::annotate {
namespace ink_test {

Image filled(int width, int height, const std::array<float, 4>& pixel) {
  Image image;
  image.width = width;
  image.height = height;
  for (int i = 0; i < width * height; ++i) {
    image.rgba.insert(image.rgba.end(), pixel.begin(), pixel.end());
  }
  return image;
}

const float* pixel_at(const Image& image, int x, int y) {
  return &image.rgba[4 * (static_cast<std::size_t>(y) * image.width + x)];
}

double coverage_sum(const Image& image) {
  double sum = 0;
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) sum += image.rgba[i];
  return sum;
}

// Fails if lines are not smooth: then their area jumps with their slope and place.
TEST(Ink, ALinesCoverageIsItsArea) {
  for (const Vec2& along : {Vec2(60, 0), Vec2(0, 60), Vec2(48, 36), Vec2(-53, 29.3)}) {
    Image image = filled(150, 150, {0, 0, 0, 0});
    Ink ink(150, 150, 0);
    const Vec2 start(75.3, 70.8);
    ink.line(start, start + along, 3);
    ink.over(image, {});
    const double area = 3 * along.norm() + 3.14159265 * 1.5 * 1.5;
    EXPECT_NEAR(coverage_sum(image), area, 0.02 * area) << along.transpose();
  }
}

TEST(Ink, PolygonsAreFilledEitherWayRound) {
  const std::array<Vec2, 3> corners = {Vec2(20, 20), Vec2(90, 35), Vec2(40, 80)};
  const std::array<Vec2, 3> reversed = {corners[2], corners[1], corners[0]};
  Image one = filled(100, 100, {0, 0, 0, 0});
  Image other = one;
  Ink a(100, 100, 0);
  a.convex(corners);
  a.over(one, {});
  Ink b(100, 100, 0);
  b.convex(reversed);
  b.over(other, {});
  EXPECT_NEAR(coverage_sum(one), 0.5 * (70 * 60 - 20 * 15), 15);
  EXPECT_EQ(one, other);
}

// Fails if crossing strokes are blended twice.
TEST(Ink, OneInkIsOneShape) {
  Image image = filled(40, 40, {0, 0, 0, 0});
  Ink ink(40, 40, 2);
  for (int i = 0; i < 2; ++i) ink.line({5, 20}, {35, 20}, 2);
  ink.line({20, 5}, {20, 35}, 2);
  ink.over(image, {{1, 1, 1}, 0.5, {0, 0, 0}, 0});
  EXPECT_FLOAT_EQ(pixel_at(image, 20, 20)[3], 0.5F);
  EXPECT_FLOAT_EQ(pixel_at(image, 10, 20)[3], 0.5F);
}

// A line over what is there, and one under it: through a pixel of opacity 3/4 a quarter is seen.
TEST(Ink, OverAndUnder) {
  Image over = filled(40, 40, {0.3F, 0, 0, 0.75F});
  Image under = over;
  Ink ink(40, 40, 0);
  ink.line({5, 20.5}, {35, 20.5}, 3);
  const Paint green = {{0, 1, 0}, 1.0, {0, 0, 0}, 0};
  ink.over(over, green);
  ink.under(under, green);
  const float* const on = pixel_at(over, 20, 20);
  EXPECT_EQ((std::array<float, 4>{on[0], on[1], on[2], on[3]}), (std::array<float, 4>{0, 1, 0, 1}));
  const float* const beneath = pixel_at(under, 20, 20);
  EXPECT_EQ((std::array<float, 4>{beneath[0], beneath[1], beneath[2], beneath[3]}),
            (std::array<float, 4>{0.3F, 0.25F, 0, 1}));
  EXPECT_EQ(pixel_at(under, 20, 30)[3], 0.75F);
}

TEST(Ink, TheHaloSurroundsAndEnds) {
  Image image = filled(60, 60, {0, 0, 0, 0});
  Ink ink(60, 60, 4);
  ink.line({10, 30.5}, {50, 30.5}, 3);
  ink.over(image, {{1, 1, 1}, 1.0, {1, 0, 0}, 0.8});
  EXPECT_FLOAT_EQ(pixel_at(image, 30, 30)[1], 1.0F);  // ink
  EXPECT_FLOAT_EQ(pixel_at(image, 30, 33)[1], 0.0F);  // halo only
  EXPECT_NEAR(pixel_at(image, 30, 33)[3], 0.8, 0.1);
  EXPECT_EQ(pixel_at(image, 30, 37)[3], 0.0F);
}

// Far outside, far across and degenerate: drawn as far as it can be seen, without harm.
TEST(Ink, ClipsWhatIsOutside) {
  Image image = filled(50, 33, {0, 0, 0, 0});
  Ink ink(50, 33, 2);
  ink.line({-1e9, -1e9}, {-5e8, 1e9}, 2);
  ink.line({1e300, 5}, {2e300, 5}, 2);
  const std::array<Vec2, 3> point = {Vec2(-9, -9), Vec2(-9, -9), Vec2(-9, -9)};
  ink.convex(point);
  ink.over(image, {});
  EXPECT_EQ(coverage_sum(image), 0);
  ink.line({-1e6, 16.5}, {1e6, 16.5}, 1);
  ink.over(image, {});
  for (int x = 0; x < 50; ++x) EXPECT_FLOAT_EQ(pixel_at(image, x, 16)[3], 1.0F);
}

}  // namespace ink_test
}  // namespace ovoid::annotate
