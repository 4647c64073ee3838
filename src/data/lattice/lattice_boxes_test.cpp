// SPDX-License-Identifier: Apache-2.0
#include "ovoid/lattice_boxes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "ovoid/error.h"

namespace ovoid {
namespace lattice_boxes_test {

using testing::HasSubstr;

LatticeBoxes two_boxes() {
  LatticeBoxes all;
  all.dims = {5, 4, 3};
  all.least = -10;
  all.greatest = 90;
  all.background = -10;
  all.step = 0.5;
  all.boxes = {{.gap = 1, .size = {3, 2, 1}, .first = 40, .rise = {4, -20, 7}},
               {.gap = 2, .size = {1, 3, 2}, .first = 100, .rise = {0, 10, 20}}};
  return all;
}

// Fails if a box lies elsewhere, if samples in boxes count to a gap, or if rises lie between other
// samples than the first and the last.
TEST(LatticeBoxes, StandForTheirSamples) {
  const std::vector<float> samples = samples_of(two_boxes());
  ASSERT_EQ(samples.size(), 60U);
  const auto at = [&](std::size_t x, std::size_t y, std::size_t z) {
    return static_cast<double>(samples[(z * 4 + y) * 5 + x]);
  };
  EXPECT_EQ(at(0, 0, 0), -10);
  // The first begins at (1, 0, 0): -10 + 0.5 * 40, and rises by 2 along x, falls by 10 along y.
  EXPECT_EQ(at(1, 0, 0), 10);
  EXPECT_EQ(at(2, 0, 0), 11);
  EXPECT_EQ(at(3, 0, 0), 12);
  EXPECT_EQ(at(1, 1, 0), 0);
  EXPECT_EQ(at(3, 1, 0), 2);
  // Free are (4, 0, 0) and (0, 1, 0), so that the second begins at (4, 1, 0).
  EXPECT_EQ(at(4, 0, 0), -10);
  EXPECT_EQ(at(0, 1, 0), -10);
  EXPECT_EQ(at(4, 1, 0), 40);
  EXPECT_EQ(at(4, 2, 0), 42.5);
  EXPECT_EQ(at(4, 3, 0), 45);
  EXPECT_EQ(at(4, 3, 1), 55);
  EXPECT_EQ(at(4, 3, 2), -10);
}

TEST(LatticeBoxes, AreRoundedAndClampedAndMayBeMissing) {
  LatticeBoxes all = two_boxes();
  all.boxes[0].first = LatticeBox::kMissing;
  all.greatest = 39;
  const std::vector<float> samples = samples_of(all);
  EXPECT_TRUE(std::isnan(samples[1]));
  EXPECT_TRUE(std::isnan(samples[8]));
  EXPECT_EQ(samples[9], 39);  // 40 of at most 39
  all.whole = true;
  all.step = 1;
  all.boxes[0].first = 7;
  all.greatest = 900;
  all.boxes[1].rise = {0, 3, 0};
  const std::vector<float> whole = samples_of(all);
  EXPECT_EQ(whole[9], 90);
  EXPECT_EQ(whole[14], 92);  // 91.5, up
  EXPECT_EQ(whole[19], 93);
}

// Fails if a box may leave the lattice, cover another, or if nonsense passes for numbers.
TEST(LatticeBoxes, RefuseWhatIsNotAsSaid) {
  const auto refusal = [](const std::function<void(LatticeBoxes&)>& spoil) {
    LatticeBoxes all = two_boxes();
    spoil(all);
    try {
      samples_of(all);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  EXPECT_THAT(refusal([](LatticeBoxes& all) { all.dims[1] = 0; }), HasSubstr("dims[1] = 0"));
  EXPECT_THAT(refusal([](LatticeBoxes& all) { all.step = 0; }), HasSubstr("step = 0"));
  EXPECT_THAT(refusal([](LatticeBoxes& all) {
                all.dims = {std::int64_t{1} << 40, std::int64_t{1} << 40, 1};
              }),
              HasSubstr("expected fewer than 2^32"));
  EXPECT_THAT(refusal([](LatticeBoxes& all) { all.greatest = 1e200; }),
              HasSubstr("1e+200: must be a float"));
  EXPECT_THAT(refusal([](LatticeBoxes& all) {
                all.whole = true;
                all.boxes[1].first = LatticeBox::kMissing;
              }),
              HasSubstr("boxes[1]: its samples are missing"));
  EXPECT_THAT(refusal([](LatticeBoxes& all) { all.least = 100; }), HasSubstr("least, greatest"));
  EXPECT_THAT(refusal([](LatticeBoxes& all) { all.background = NAN; }), HasSubstr("background"));
  EXPECT_THAT(refusal([](LatticeBoxes& all) { all.boxes[1].size[2] = 4; }),
              HasSubstr("boxes[1]: its size along z is 4: expected 1 to 3"));
  EXPECT_THAT(refusal([](LatticeBoxes& all) { all.boxes[1].size[0] = 0; }),
              HasSubstr("its size along x is 0"));
  EXPECT_THAT(refusal([](LatticeBoxes& all) { all.boxes[1].gap = -1; }), HasSubstr("gap = -1"));
  EXPECT_THAT(refusal([](LatticeBoxes& all) { all.boxes[1].gap = 54; }),
              HasSubstr("boxes[1]: its gap reaches beyond the lattice"));
  EXPECT_THAT(refusal([](LatticeBoxes& all) {
                all.boxes[0].gap = 6;                          // from (1, 1, 0)
                all.boxes[1] = {.gap = 1, .size = {2, 1, 1}};  // (0, 2, 0)
              }),
              HasSubstr("boxes[1]: it overlaps one before"));
}

TEST(LatticeBoxes, TellOfProgressAndStop) {
  LatticeBoxes all = two_boxes();
  std::vector<double> told;
  samples_of(all, {}, [&](double fraction) { told.push_back(fraction); });
  EXPECT_EQ(told.back(), 1);
  std::stop_source source;
  source.request_stop();
  EXPECT_THROW(samples_of(all, source.get_token()), Error);
}

}  // namespace lattice_boxes_test
}  // namespace ovoid
