// SPDX-License-Identifier: Apache-2.0
// `ovoid render --part` and `ovoid composite`. Fails if parts do not make the picture, or if parts
// that do not belong together do.
#include <gtest/gtest.h>

#include <string>

#include "program.h"

namespace ovoid::cli_tests {
namespace composite_test {

class Composite : public testing::Test {
 protected:
  void SetUp() override { expect_success({"make", "head", "--size", "32", "-o", head_}); }

  Words part(const std::string& choice, const std::string& file, const Words& more = {}) const {
    Words words = {"render", head_, "--size", "80x60", "--part", choice, "-o", file};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }

  Folder folder_;
  std::string head_ = folder_ / "head.nrrd", first_ = folder_ / "1.exr",
              second_ = folder_ / "2.exr", picture_ = folder_ / "picture.npy";
};

// In any order.
TEST_F(Composite, PartsMakeThePicture) {
  for (const char* const mode : {"composite", "xray", "maximum", "minimum", "mean", "isosurface"}) {
    Words flags = {"--mode", mode};
    if (flags.back() == "isosurface") flags.insert(flags.end(), {"--iso", "0.5"});
    const std::string whole = folder_ / "whole.npy";
    expect_success(part("1/2", first_, flags));
    expect_success(part("2/2", second_, flags));
    expect_success({"composite", second_, first_, "-o", picture_});
    Words words = {"render", head_, "--size", "80x60", "--sheets", "image", "-o", whole};
    words.insert(words.end(), flags.begin(), flags.end());
    expect_success(words);
    const Picture together = read_npy(picture_);
    const Picture alone = read_npy(whole);
    ASSERT_EQ(together.rgba.size(), alone.rgba.size());
    EXPECT_GT(together.num_covered(), 100U);
    const float peak = *std::max_element(alone.rgba.begin(), alone.rgba.end());
    for (std::size_t i = 0; i < alone.rgba.size(); ++i)
      ASSERT_NEAR(together.rgba[i], alone.rgba[i], std::max(peak, 1.0F) / 255) << mode;
    expect_success({"composite", first_, second_, "-o", folder_ / "picture.png"});
  }
}

TEST_F(Composite, WhatDoesNotBelongTogetherIsRefused) {
  expect_success(part("1/2", first_));
  expect_failure({"composite", first_, "-o", picture_}, 1, {"of 2 parts these are not given: 2"});
  expect_failure({"composite", first_, first_, "-o", picture_}, 1, {"is part 1 of 2, and so is"});
  expect_success(part("2/2", second_, {"--azimuth", "20"}));
  expect_failure({"composite", first_, second_, "-o", picture_}, 1,
                 {second_, "another picture", "'camera'"});
  expect_success(part("2/3", second_));
  expect_failure({"composite", first_, second_, "-o", picture_}, 1, {"one of 3 parts"});
  expect_failure({"composite", first_, head_, "-o", picture_}, 1,
                 {head_, "not a part of a picture"});
  expect_failure({"composite", first_, second_, "-o", first_}, 2, {"--output"});
  expect_failure({"composite", "-o", picture_}, 2, {"no parts given"});
  EXPECT_FALSE(std::filesystem::exists(picture_));
}

TEST_F(Composite, PartsRefuseWhatNeedsAWhole) {
  expect_failure(part("3/2", first_), 2, {"--part", "K/N"});
  expect_failure(part("0/2", first_), 2, {"--part", "K/N"});
  expect_failure(part("1/2", picture_), 2, {"--part", ".exr"});
  expect_failure(part("1/2", first_, {"--axes"}), 2, {"--part", "--axes"});
  expect_failure(part("1/2", first_, {"--value-plane", "1,0,0,0"}), 2, {"--value-plane"});
  expect_failure(part("1/2", first_, {"--sheets", "lattice"}), 2, {"image sheets"});
}

}  // namespace composite_test
}  // namespace ovoid::cli_tests
