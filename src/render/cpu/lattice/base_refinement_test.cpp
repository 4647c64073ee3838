// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/lattice/base_refinement.h"

#include <gtest/gtest.h>

#include <functional>

#include "render/cpu/tile_output.h"

namespace ovoid::cpu {
namespace base_refinement_test {

using Shade = std::function<float(int x, int y)>;

// Every other sample of a picture of that size, all channels alike.
Image every_other(int width, int height, const Shade& shade) {
  Image few = empty_image((width - 1 + 1) / 2 + 1, (height - 1 + 1) / 2 + 1);
  for (int y = 0; y < few.height; ++y) {
    for (int x = 0; x < few.width; ++x) {
      const std::size_t at = static_cast<std::size_t>(y) * few.width + x;
      std::fill_n(few.rgba.data() + 4 * at, 4, shade(2 * x, 2 * y));
      few.depth[at] = static_cast<float>(x);
    }
  }
  return few;
}

bool is_wanted(const SampleMask& mask, int x, int y) {
  return (mask.of_tile(x, y)[y % kTileSize] >> (x % kTileSize) & 1U) != 0;
}

// Fails if a weight or a place is off, or an edge is interpolated.
TEST(BaseRefinement, FillsWhatIsSmooth) {
  constexpr int kWidth = 101, kHeight = 74;
  const Shade shade = [](int x, int y) {
    return 0.1F + 0.004F * static_cast<float>(x) + 0.003F * static_cast<float>(y) +
           2e-5F * static_cast<float>(x * x);
  };
  const auto runner = make_runner(2);
  Image picture = empty_image(kWidth, kHeight);
  const SampleMask mask =
      interpolate_smooth(every_other(kWidth, kHeight, shade), 1.0, picture, *runner);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const std::size_t at = static_cast<std::size_t>(y) * kWidth + x;
      EXPECT_FALSE(is_wanted(mask, x, y)) << x << ' ' << y;
      // Where a cubic lacks a neighbour it takes the outermost sample again.
      const bool is_inside = x > 1 && y > 1 && x < kWidth - 3 && y < kHeight - 3;
      EXPECT_NEAR(picture.rgba[4 * at + 2], shade(x, y), is_inside ? 1e-5 : 2e-3) << x << ' ' << y;
      if (!is_inside) continue;
      EXPECT_NEAR(picture.depth[at], 0.5 * x, 1e-5);
    }
  }
}

TEST(BaseRefinement, LeavesWhatIsSharp) {
  constexpr int kWidth = 96, kHeight = 64;
  const auto runner = make_runner(2);
  Image picture = empty_image(kWidth, kHeight);
  const SampleMask mask = interpolate_smooth(
      every_other(kWidth, kHeight, [](int x, int) { return x < 40 ? 0.0F : 0.5F; }), 0.1, picture,
      *runner);
  for (int y = 0; y < kHeight; ++y) {
    EXPECT_TRUE(is_wanted(mask, 39, y));
    for (const int x : {0, 20, 34, 45, 70, 95}) EXPECT_FALSE(is_wanted(mask, x, y)) << x;
  }
  EXPECT_FALSE(mask.is_empty(32, 0));
  EXPECT_TRUE(mask.is_empty(0, 0));
  EXPECT_EQ(picture.rgba[4 * 70], 0.5F);
  EXPECT_EQ(picture.depth[71], 35);  // samples of ten sheets apart have nothing between them
  EXPECT_EQ(picture.rgba[4 * 20], 0.0F);
}

TEST(BaseRefinement, EveryNthSampleLiesWhereItDid) {
  view::BasePlane base;
  base.width = 22;
  base.height = 13;
  base.per_x = Vec3(0.1, 0, 0);
  base.per_y = Vec3(0, 0.2, 0);
  base.depth = {1.0, 0.01, 0.02};
  base.picture_from_base.matrix << 2, 0.1, 3, -0.2, 1.5, 4, 0.001, 0.002, 1;
  base.base_from_picture.matrix = base.picture_from_base.matrix.inverse();
  const view::BasePlane few = every_nth_sample(base, 4);
  EXPECT_EQ(few.width, 7);  // the last reaches beyond
  EXPECT_EQ(few.height, 4);
  const Eigen::Vector2d place = few.picture_from_base(3, 2);
  EXPECT_NEAR((place - base.picture_from_base(12, 8)).norm(), 0, 1e-12);
  EXPECT_NEAR(few.depth.at(3, 2), base.depth.at(12, 8), 1e-12);
  const Eigen::Vector2d back = few.base_from_picture(place[0], place[1]);
  EXPECT_NEAR(back[0], 3, 1e-9);
  EXPECT_NEAR(back[1], 2, 1e-9);
}

}  // namespace base_refinement_test
}  // namespace ovoid::cpu
