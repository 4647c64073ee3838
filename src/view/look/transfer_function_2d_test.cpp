// SPDX-License-Identifier: Apache-2.0
#include "ovoid/transfer_function_2d.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>

#include "ovoid/error.h"
#include "view/look/look_2d.h"

namespace ovoid {
namespace transfer_function_2d_test {

using Rgba = TransferFunction2D::Rgba;

// Numbers without a pattern, all visible.
std::vector<Rgba> random_entries(int count) {
  std::mt19937 random(7);  // NOLINT(cert-msc51-cpp): the same table every time
  std::uniform_real_distribution<float> share(0.01F, 1);
  std::vector<Rgba> entries(static_cast<std::size_t>(count));
  for (Rgba& entry : entries) entry = {share(random), share(random), share(random), share(random)};
  return entries;
}

std::string refusal(const std::function<void()>& make) {
  try {
    make();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    return error.what();
  }
  return "made";
}

// Written out: the four entries around, each by the area opposite.
TEST(TransferFunction2D, IsBilinear) {
  const std::vector<Rgba> entries = random_entries(5 * 4);
  const TransferFunction2D function({-2, 6, 5}, {1, 4, 4}, entries);
  for (const double value : {-9.0, -2.0, -1.3, 0.0, 3.9, 5.99, 6.0, 40.0}) {
    for (const double gradient : {0.0, 1.0, 1.7, 2.0, 3.5, 4.0, 9.0}) {
      const double x = std::min(std::max((value + 2) / 2, 0.0), 4.0);
      const double y = std::min(std::max(gradient - 1, 0.0), 3.0);
      double expected[4] = {};
      for (int j = 0; j < 4; ++j) {
        for (int i = 0; i < 5; ++i) {
          const double weight =
              std::max(0.0, 1 - std::abs(x - i)) * std::max(0.0, 1 - std::abs(y - j));
          for (std::size_t c = 0; c < 4; ++c)
            expected[c] +=
                weight * static_cast<double>(entries[static_cast<std::size_t>(5 * j + i)][c]);
        }
      }
      const auto found = function.at(value, gradient);
      for (std::size_t c = 0; c < 4; ++c) EXPECT_NEAR(found[c], expected[c], 1e-12);
    }
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(function.at(nan, 1)[3], 0);
  EXPECT_EQ(function.at(1, nan)[3], 0);
}

// Fails if the rim of what shows is darkened by entries that nobody gave a colour.
TEST(TransferFunction2D, TransparentEntriesTakeTheirNeighboursColor) {
  std::vector<Rgba> entries(9);
  entries[4] = {1, 0.5F, 0.25F, 1};
  const TransferFunction2D function({0, 2, 3}, {0, 2, 3}, entries);
  const auto rim = function.at(0.1, 0.2);
  EXPECT_EQ(rim[0], 1);
  EXPECT_EQ(rim[1], 0.5);
  EXPECT_NEAR(rim[3], 0.02, 1e-7);
}

TEST(TransferFunction2D, RegionsHaveSoftEdgesAndLieOverEachOther) {
  const LookRegion box{
      .values = {10, 20}, .gradients = {0, 8}, .rgb = {1, 0, 0}, .opacity = 0.5, .softness = 0.4};
  const TransferFunction2D one({box});
  constexpr double kCell = 0.02;             // an entry's rounding of the edges
  EXPECT_NEAR(one.at(15, 0)[3], 0.5, 1e-6);  // on the ground there is no edge
  EXPECT_NEAR(one.at(15, 4)[3], 0.5, 1e-6);
  EXPECT_NEAR(one.at(11, 4)[3], 0.25, kCell);  // half of two fifths of the way to the middle
  EXPECT_NEAR(one.at(15, 7.2)[3], 0.25, kCell);
  EXPECT_EQ(one.at(9.9, 4)[3], 0);
  EXPECT_EQ(one.at(15, 8.2)[3], 0);
  EXPECT_EQ(one.at(1e30, 1e30)[3], 0);

  LookRegion tip = box;
  tip.foot = 0;
  tip.softness = 0;
  const TransferFunction2D triangle({tip});
  EXPECT_NEAR(triangle.at(13.2, 4)[3], 0.5, 1e-6);  // from 12.5 to 17.5 at half the height
  EXPECT_NEAR(triangle.at(12.2, 4)[3], 0, 1e-6);

  LookRegion over = box;
  over.rgb = {0, 0, 1};
  const TransferFunction2D both({box, over});
  const auto middle = both.at(15, 4);
  EXPECT_NEAR(middle[3], 0.75, 1e-6);
  EXPECT_NEAR(middle[2], 0.5 / 0.75, 1e-6);
  EXPECT_NEAR(middle[0], 0.25 / 0.75, 1e-6);

  LookRegion bell = box;
  bell.shape = LookRegion::Shape::kGaussian;
  const TransferFunction2D soft({bell});
  EXPECT_NEAR(soft.at(15, 4)[3], 0.5, 1e-3);
  EXPECT_NEAR(soft.at(18, 4)[3], 0.5 * std::exp(-0.5), 1e-3);  // a sigma is 0.3 of the side
}

TEST(TransferFunction2D, RefusesWhatIsNoTable) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto with_axes = [](TransferFunction2D::Axis values, TransferFunction2D::Axis gradients) {
    return refusal([&] { TransferFunction2D(values, gradients, std::vector<Rgba>(4)); });
  };
  EXPECT_NE(with_axes({0, 1, 0}, {0, 1, 2}).find("0 along the value: must be 2 to"),
            std::string::npos);
  EXPECT_NE(with_axes({0, 1, 2}, {0, 1, 5000}).find("5000 along the gradient"), std::string::npos);
  EXPECT_NE(with_axes({0, 1, 4096}, {0, 1, 4096}).find("must be at most"), std::string::npos);
  EXPECT_NE(with_axes({0, 1, 3}, {0, 1, 2}).find("4 entries: must be 3 x 2"), std::string::npos);
  EXPECT_NE(with_axes({1, 0, 2}, {0, 1, 2}).find("values = 1, 0"), std::string::npos);
  EXPECT_NE(with_axes({0, nan, 2}, {0, 1, 2}).find("values = 0, nan"), std::string::npos);
  EXPECT_NE(with_axes({0, 1, 2}, {-1, 1, 2}).find("gradients = -1, 1: must be >= 0"),
            std::string::npos);
  EXPECT_NE(refusal([] {
              TransferFunction2D({0, 1, 2}, {0, 1, 2}, {Rgba{}, Rgba{0, 0, 0, 2}, Rgba{}, Rgba{}});
            }).find("entry 1 of row 0 has 2 as opacity"),
            std::string::npos);
  const auto with_region = [](const std::function<void(LookRegion&)>& change) {
    LookRegion region;
    change(region);
    return refusal([&] { TransferFunction2D({LookRegion{}, region}); });
  };
  EXPECT_NE(with_region([](LookRegion& r) {
              r.values = {2, 1};
            }).find("regions[1].values = 2, 1"),
            std::string::npos);
  EXPECT_NE(with_region([](LookRegion& r) {
              r.gradients = {-2, 1};
            }).find("regions[1].gradients"),
            std::string::npos);
  EXPECT_NE(with_region([&](LookRegion& r) { r.opacity = nan; }).find("regions[1].opacity = nan"),
            std::string::npos);
  EXPECT_NE(with_region([](LookRegion& r) { r.rgb[2] = 2; }).find("regions[1].rgb[2] = 2"),
            std::string::npos);
  EXPECT_NE(with_region([](LookRegion& r) { r.foot = -1; }).find("regions[1].foot"),
            std::string::npos);
  EXPECT_NE(refusal([] { TransferFunction2D(std::vector<LookRegion>{}); }).find("0 regions"),
            std::string::npos);
}

// What is skipped is decided by the envelope: nowhere may the function show more.
TEST(Look2D, EnvelopeIsNowhereLess) {
  const TransferFunction2D function({0, 4, 5}, {0, 3, 4}, random_entries(20));
  const TransferFunction envelope = view::envelope_of(function, {});
  for (double value = -1; value < 5; value += 0.07) {
    for (double gradient = 0; gradient < 4; gradient += 0.11)
      EXPECT_LE(function.at(value, gradient)[3], envelope.opacity_at(value) + 1e-7);
  }
}

// Fails if a change along either axis takes no steps.
TEST(Look2D, VariationBoundsEveryChange) {
  const TransferFunction2D function({0, 4, 5}, {0, 3, 4}, random_entries(20));
  const view::LookTable table(view::envelope_of(function, {}));
  const view::Variation2D variation = view::variation_of(function, table, 1);
  std::mt19937 random(3);  // NOLINT(cert-msc51-cpp): the same places every time
  std::uniform_real_distribution<double> value(0.01, 3.99), gradient(0, 3);
  for (int i = 0; i < 500; ++i) {
    const double v[2] = {value(random), value(random)};
    const double g[2] = {gradient(random), gradient(random)};
    const double change = std::abs(function.at(v[1], g[1])[3] - function.at(v[0], g[0])[3]);
    const auto up_to = [&](int k) {
      return static_cast<double>(table.read(variation.by_value, static_cast<float>(v[k])));
    };
    const auto by_gradient = [&](int k) {
      return view::variation_at(variation.by_gradient, function.gradients(), g[k]);
    };
    EXPECT_LE(change,
              std::abs(up_to(1) - up_to(0)) + std::abs(by_gradient(1) - by_gradient(0)) + 2e-3);
  }
}

}  // namespace transfer_function_2d_test
}  // namespace ovoid
