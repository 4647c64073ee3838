// SPDX-License-Identifier: Apache-2.0
// The comparison of pictures that other tests trust: known differences give known numbers, and a
// failure leaves evidence.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "ovoid/error.h"
#include "support/compare.h"

namespace ovoid::test {
namespace support_test {

// Ten pixels, half of them covered by gray of alpha 1.
Image half_covered() {
  Image image;
  image.width = 5;
  image.height = 2;
  image.rgba.assign(40, 0.0F);
  image.depth.assign(10, std::numeric_limits<float>::infinity());
  image.front_depth = image.depth;
  for (std::size_t p = 0; p < 5; ++p) {
    for (std::size_t c = 0; c < 3; ++c) image.rgba[4 * p + c] = 0.5F;
    image.rgba[4 * p + 3] = 1.0F;
    image.depth[p] = 7.0F;
  }
  return image;
}

TEST(Compare, EqualPictures) {
  const ImageDifference difference = compare(half_covered(), half_covered());
  EXPECT_TRUE(std::isinf(difference.psnr_db));
  EXPECT_EQ(difference.max_8bit, 0);
  EXPECT_EQ(difference.num_covered, 5);
  EXPECT_EQ(difference.num_depth_missing, 0);
  EXPECT_TRUE(agree(half_covered(), half_covered(), "equal"));
}

// One channel of one of five covered pixels off by 0.1: a mean square of 0.01 / 20.
TEST(Compare, OneChannelOff) {
  Image actual = half_covered();
  actual.rgba[4 * 3 + 1] += 0.1F;
  actual.depth[1] = std::numeric_limits<float>::infinity();
  actual.depth[2] = 7.5F;
  const ImageDifference difference = compare(actual, half_covered());
  EXPECT_NEAR(difference.psnr_db, -10 * std::log10(0.01 / 20), 1e-4);
  EXPECT_NEAR(difference.psnr_db, psnr(actual, half_covered()), 1e-9);
  EXPECT_EQ(difference.max_8bit, 153 - 128);
  EXPECT_NEAR(difference.max_float, 0.1, 1e-6);
  EXPECT_EQ(difference.worst_x, 3);
  EXPECT_EQ(difference.worst_y, 0);
  EXPECT_EQ(difference.num_depth_missing, 1);
  EXPECT_EQ(difference.max_depth, 0.5);
}

// A peak scales colours, not opacity; NaN in one picture never agrees.
TEST(Compare, PeakAndNan) {
  Image actual = half_covered();
  actual.rgba[0] += 0.1F;
  EXPECT_NEAR(compare(actual, half_covered(), 10).max_float, 0.01, 1e-6);
  actual.rgba[0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(std::isinf(compare(actual, half_covered()).max_float));
  EXPECT_FALSE(compare(actual, half_covered()).psnr_db > 0);
  Image narrow = half_covered();
  narrow.width = 2;
  narrow.height = 5;
  EXPECT_THROW(compare(narrow, half_covered()), Error);
}

// A failing comparison says by how much, and writes what it compared.
TEST(Compare, FailureLeavesEvidence) {
  const std::filesystem::path folder = OVOID_TEST_OUTPUT;
  const char* names[] = {"evidence_actual.npy", "evidence_expected.npy", "evidence_difference.png"};
  for (const char* name : names) std::filesystem::remove(folder / name);
  Image actual = half_covered();
  actual.rgba[4 * 3 + 1] += 0.1F;
  const testing::AssertionResult result = agree(actual, half_covered(), "evidence");
  EXPECT_FALSE(result);
  EXPECT_NE(std::string(result.message()).find("worst at (3, 0)"), std::string::npos)
      << result.message();
  for (const char* name : names) EXPECT_TRUE(std::filesystem::exists(folder / name)) << name;
}

}  // namespace support_test
}  // namespace ovoid::test
