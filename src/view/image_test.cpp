// SPDX-License-Identifier: Apache-2.0
#include "ovoid/image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "ovoid/error.h"

namespace ovoid {
namespace image_test {

Image picture(int width, int height, std::vector<float> rgba) {
  Image image;
  image.width = width;
  image.height = height;
  image.rgba = std::move(rgba);
  return image;
}

using Bytes8 = std::vector<std::uint8_t>;

// Fails if colour is not divided by alpha, if rounding truncates, or if a transparent pixel keeps a
// colour.
TEST(ToRgba8, IsStraightAlphaRoundedHalfUp) {
  const Image image = picture(2, 2,
                              {0.25F, 0.125F, 0.0F, 0.5F,  // straight 1/2, 1/4, 0: 127.5, 63.75, 0
                               0.0F, 0.0F, 0.0F, 0.0F,     // transparent
                               1.0F, 0.5F, 0.25F, 1.0F,    // opaque
                               2.0F, -1.0F, 0.5F, 1.0F});  // out of range: clamped
  EXPECT_EQ(to_rgba8(image),
            (Bytes8{128, 64, 0, 128, 0, 0, 0, 0, 255, 128, 64, 255, 255, 0, 128, 255}));
}

TEST(ToRgba8, BlendsTheBackgroundBehind) {
  const Rgb background{1.0, 0.5, 0.0};
  const Image image = picture(2, 1, {0.25F, 0.0F, 0.5F, 0.5F, 0.0F, 0.0F, 0.0F, 0.0F});
  EXPECT_EQ(to_rgba8(image, background), (Bytes8{191, 64, 128, 255, 255, 128, 0, 255}));
}

TEST(ToRgba8, WritesZeroForWhatIsNotANumber) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(to_rgba8(picture(2, 1, {nan, 1, 0, 1, 1, 1, 1, nan})),
            (Bytes8{0, 255, 0, 255, 0, 0, 0, 0}));
}

TEST(ToRgba8, RefusesABufferOfAnotherSize) {
  EXPECT_THROW(to_rgba8(picture(2, 2, {0, 0, 0, 0})), Error);
  EXPECT_TRUE(to_rgba8(Image()).empty());
}

// Fails if uncovered pixels dilute the mean, or if a channel is left out.
TEST(Psnr, IsOverFourChannelsOfThePixelsCoveredInEither) {
  const Image a = picture(3, 1, {0.5F, 0.5F, 0.5F, 1, 0, 0, 0, 0, 0, 0, 0, 0});
  Image b = a;
  EXPECT_EQ(psnr(a, b), std::numeric_limits<double>::infinity());
  b.rgba[0] = 0.25F;  // squares: 1/16 over one covered pixel of four channels
  EXPECT_NEAR(psnr(a, b), -10.0 * std::log10(1.0 / 64.0), 1e-12);
  b.rgba[7] = 0.5F;  // a second pixel, covered in b only: (1/16 + 1/4) / 8
  EXPECT_NEAR(psnr(a, b), -10.0 * std::log10(0.3125 / 8.0), 1e-12);
  EXPECT_EQ(psnr(a, b), psnr(b, a));
}

TEST(Psnr, OfNotANumberIsNotANumber) {
  const Image a = picture(1, 1, {0.5F, 0.5F, 0.5F, 1});
  Image b = a;
  b.rgba[3] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(std::isnan(psnr(a, b)));
}

TEST(Psnr, RefusesPicturesOfDifferentSize) {
  EXPECT_THROW(psnr(picture(2, 1, std::vector<float>(8)), picture(1, 2, std::vector<float>(8))),
               Error);
  EXPECT_THROW(psnr(picture(2, 1, std::vector<float>(8)), picture(2, 1, std::vector<float>(4))),
               Error);
}

}  // namespace image_test
}  // namespace ovoid
