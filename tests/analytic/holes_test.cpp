// SPDX-License-Identifier: Apache-2.0
// A scan of air at -1000 shows nothing but -1000, at its faces and around a hole of NaN and
// infinity, in every mode.
#include <gtest/gtest.h>

#include <cmath>

#include "render/reference/field_evaluator.h"
#include "render/reference/reference_renderer.h"
#include "support/scenes.h"
#include "support/tolerances.h"
#include "support/volumes.h"

namespace ovoid::test {
namespace holes_test {

using reference::render;

constexpr double kAir = -1000;

VolumeFunction air_with_a_hole(double value) {
  return [value](std::int64_t i, std::int64_t j, std::int64_t k) {
    const bool is_hole = std::abs(i - 6) <= 2 && std::abs(j - 5) <= 1 && std::abs(k - 7) <= 2;
    if (!is_hole) return value;
    return (i + j + k) % 2 == 0 ? kMissing : std::numeric_limits<double>::infinity();
  };
}

LatticeField air() { return make_field({13, 12, 14}, air_with_a_hole(kAir)); }

// White from -1000.01 to -999.99, else red: any other value shows.
Look air_look(Mode mode) {
  Look look;
  look.transfer_function.colors = {{-1001, {1, 0, 0}},       {kAir - 0.01, {1, 0, 0}},
                                   {kAir - 0.01, {1, 1, 1}}, {kAir + 0.01, {1, 1, 1}},
                                   {kAir + 0.01, {1, 0, 0}}, {0, {1, 0, 0}}};
  look.transfer_function.opacities = {{-1001, 0.05}, {0, 0.05}};
  look.unit_distance = 1;
  look.shade = false;
  look.mode = mode;
  return look;
}

// Fails if missing samples count as zeros, or NaN gets into a sum.
TEST(Holes, FieldIsOneValue) {
  const reference::FieldEvaluator field(air());
  int num_defined = 0;
  for (double x = -0.7; x < 13; x += 0.31) {
    for (double y = -0.7; y < 12; y += 0.33) {
      for (double z = -0.7; z < 14; z += 0.35) {
        for (const bool is_mean : {false, true}) {
          const Vec3 u(x, y, z);
          const auto sample = is_mean && num_defined % 16 == 0
                                  ? field.mean_over(u, u + Vec3(0.4, 0.3, 0.8))
                                  : field.at_index(u, is_mean ? Vec3(1.5, 1, 2) : Vec3(1, 1, 1));
          if (!sample.is_defined) continue;
          ++num_defined;
          ASSERT_NEAR(sample.value, kAir, 1000 * kDoubleRelative) << u.transpose();
          ASSERT_LE(sample.gradient.norm(), 1000 * 10 * kDoubleRelative) << u.transpose();
        }
      }
    }
  }
  EXPECT_GT(num_defined, 50000);
}

// The hole is a hole: undefined in its middle, as deep as half a spacing from the next samples.
TEST(Holes, AreUndefined) {
  const reference::FieldEvaluator field(air());
  EXPECT_FALSE(field.at_index({6, 5, 7}).is_defined);
  EXPECT_FALSE(field.at_index({6, 5, 9}).is_defined);
  EXPECT_FALSE(field.at_index({6, 5, 9.4}).is_defined);
  EXPECT_TRUE(field.at_index({6, 5, 9.5}).is_defined);
  EXPECT_TRUE(field.at_index({6, 6.5, 7}).is_defined);
}

class HolesInMode : public testing::TestWithParam<std::tuple<Mode, Slab>> {};

// Fails if a picture has any colour but white in it, or a pixel beside the volume is covered.
TEST_P(HolesInMode, ShowNoOtherValue) {
  const auto [mode, slab] = GetParam();
  const Camera camera = perspective_camera({6, 5.5, 6.5}, {0.3, -0.2, 1}, 10, 40);
  RenderOptions options = picture(32, 32, slab == Slab::kMid ? 0.7 : 2.0, slab);
  const Image image = render(air(), camera, air_look(mode), options).image;
  int num_covered = 0;
  for (int y = 0; y < options.height; ++y) {
    for (int x = 0; x < options.width; ++x) {
      const Pixel at = pixel(image, x, y);
      if (at.a() > 0) ++num_covered;
      ASSERT_NEAR(at.g(), at.a(), 1e-6) << x << " " << y;
      ASSERT_NEAR(at.r(), at.a(), 1e-6) << x << " " << y;
    }
  }
  EXPECT_GT(num_covered, 300);
  EXPECT_EQ(pixel(image, 0, 0).a(), 0);
}

INSTANTIATE_TEST_SUITE_P(Modes, HolesInMode,
                         testing::Combine(testing::Values(Mode::kComposite, Mode::kMaximum,
                                                          Mode::kMean),
                                          testing::Values(Slab::kMid, Slab::kMean)));

// X-ray integrals are -1000 times the lengths, which a volume of ones tells; and no isosurface is
// found at any other value.
TEST(Holes, XrayAndIsosurfaceShowNoOtherValue) {
  const Camera camera = perspective_camera({6, 5.5, 6.5}, {0.3, -0.2, 1}, 10, 40);
  const RenderOptions options = picture(32, 32, 0.7);
  const Look look = air_look(Mode::kXray);
  const Image integral = render(air(), camera, look, options).image;
  const Image length =
      render(make_field({13, 12, 14}, air_with_a_hole(1)), camera, look, options).image;
  for (std::size_t n = 0; n < integral.rgba.size(); n += 4) {
    ASSERT_EQ(integral.rgba[n + 3], length.rgba[n + 3]);
    ASSERT_NEAR(static_cast<double>(integral.rgba[n]), kAir * static_cast<double>(length.rgba[n]),
                20000 * kFloatRelative);
  }
  Look surface = air_look(Mode::kIsosurface);
  for (const double iso : {-1000.001, -999.999, -500.0, 0.0}) {
    surface.isovalue = iso;
    const Image image = render(air(), camera, surface, options).image;
    for (const float number : image.rgba) ASSERT_EQ(number, 0) << iso;
  }
}

}  // namespace holes_test
}  // namespace ovoid::test
