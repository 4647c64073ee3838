// SPDX-License-Identifier: Apache-2.0
#include "render/field_levels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "ovoid/error.h"
#include "ovoid/renderer.h"
#include "support/agreement.h"
#include "support/scenes.h"
#include "support/volumes.h"
#include "support/where.h"

namespace ovoid::test {
namespace field_levels_test {

// Smooth over some ten samples, the same in every direction but for its place.
VolumeFunction rings(const Index3& dims) {
  return [dims](std::int64_t i, std::int64_t j, std::int64_t k) {
    const auto at = [](std::int64_t i, std::int64_t n) {
      return 2.0 * static_cast<double>(i) / static_cast<double>(n) - 1;
    };
    const double r = std::hypot(at(i, dims[0]), at(j, dims[1]) + 0.1, at(k, dims[2]) - 0.05);
    return 0.5 + 0.5 * std::cos(9 * r) * std::exp(-r * r);
  };
}

// A parallel view of pixels so many spacings (of the lattice's first axis) wide.
TestScene view_of(const LatticeField& field, double spacings, const Look& look) {
  const double pixel = spacings * field.geometry().spacing()[0];
  constexpr int kPixels = 30;
  return {field,
          parallel_camera(field.world_bounds().center(), Vec3(0.48, -0.31, 0.82),
                          0.5 * kPixels * pixel, 1000),
          look, picture(kPixels, kPixels)};
}

int level_of(const TestScene& scene) {
  return coarsest_level(scene.field, scene.camera, scene.options);
}

TEST(FieldLevels, DoubleTheSpacingUpToAPixel) {
  OVOID_NIGHTLY_ON_DEVICE();
  const Index3 dims{130, 128, 96};
  const LatticeField field = make_field(dims, rings(dims));
  const Look look = gray_look(0, 1, 0.1);
  EXPECT_EQ(level_of(view_of(field, 0.5, look)), 0);
  EXPECT_EQ(level_of(view_of(field, 1.99, look)), 0);
  EXPECT_EQ(level_of(view_of(field, 2, look)), 1);
  EXPECT_EQ(level_of(view_of(field, 3.99, look)), 1);
  EXPECT_EQ(level_of(view_of(field, 4, look)), 2);
  EXPECT_EQ(level_of(view_of(field, 64, look)), 2);  // of 33 samples
  for (const PostConvolution how : {PostConvolution::kOff, PostConvolution::kCubic}) {
    TestScene scene = view_of(field, 4, look);
    scene.options.post_convolution = how;
    EXPECT_EQ(level_of(scene), 0);
  }
  TestScene within = view_of(field, 4, look);
  within.camera = perspective_camera(field.world_bounds().center(), Vec3(0, 0, -1), 80, 20);
  EXPECT_EQ(level_of(within), 0) << "the nearest pixels are narrow";
}

// A pixel must be wide along every axis that has several samples.
TEST(FieldLevels, AreOfTheWidestSpacing) {
  OVOID_NIGHTLY_ON_DEVICE();
  FieldSetup thick;
  thick.world_from_index = scaled_axes(Vec3(1, 1, 5));
  const Look look = gray_look(0, 1, 0.1);
  const Index3 dims{128, 128, 40}, slice{128, 128, 1};
  EXPECT_EQ(level_of(view_of(make_field(dims, rings(dims), thick), 4, look)), 0);
  EXPECT_EQ(level_of(view_of(make_field(dims, rings(dims), thick), 10, look)), 1);
  EXPECT_EQ(level_of(view_of(make_field(slice, rings(slice), thick), 4, look)), 2);
}

// What pixels would show if each were the mean of 4 x 4.
Image mean_of_finer(TestScene scene) {
  constexpr int kTimes = 4;
  const int width = scene.options.width, height = scene.options.height;
  scene.options.width *= kTimes;
  scene.options.height *= kTimes;
  scene.options.post_convolution = PostConvolution::kOff;
  const Image fine = draw(scene).image;
  Image mean = fine;
  mean.width = width;
  mean.height = height;
  mean.rgba.assign(std::size_t{4} * width * height, 0.0F);
  mean.depth.assign(std::size_t{1} * width * height, 0.0F);
  mean.front_depth = mean.depth;
  for (std::size_t p = 0; p < fine.rgba.size(); ++p) {
    const std::size_t x = p / 4 % fine.width / kTimes, y = p / 4 / fine.width / kTimes;
    mean.rgba[4 * (y * width + x) + p % 4] += fine.rgba[p] / (kTimes * kTimes);
  }
  return mean;
}

// Pictures by levels are as near to what pixels should show as those by the widened kernels alone.
TEST(FieldLevels, LoseNothingThatPixelsCanShow) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  OVOID_NIGHTLY_ON_DEVICE();
  const Index3 dims{67, 60, 44};
  const auto with_holes = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return i > 40 && j > 33 ? kMissing : rings(dims)(i, j, k);
  };
  FieldSetup gaussian, spline, sum;
  spline.kernel = {.kind = LatticeKernelKind::kBSpline};
  sum.reconstruction = Reconstruction::kSum;
  const std::vector<std::pair<std::string, LatticeField>> fields = {
      {"B-spline", make_field(dims, rings(dims), spline)},
      {"Gaussian", make_field(dims, rings(dims), gaussian)},
      {"holes", make_field(dims, with_holes, spline)},
      {"sum", make_field(dims, rings(dims), sum)}};
  for (const auto& [name, field] : fields) {
    const bool is_sum = name == "sum";
    for (const TestLook& look : test_looks(0, is_sum ? 2.0 : 1.0)) {
      for (const double spacings : {2.0, 2.9}) {
        TestScene scene = view_of(field, is_sum ? 2 * spacings : spacings, look.look);
        ASSERT_GT(level_of(scene), 0) << name;
        const Image expected = mean_of_finer(scene);
        const double by_level = compare(draw(scene).image, expected).psnr_db;
        scene.options.post_convolution = PostConvolution::kOff;
        const double by_kernels = compare(draw(scene).image, expected).psnr_db;
        EXPECT_GE(by_level, by_kernels - kLevelsLoseDb)
            << name << ", " << look.name << ", " << spacings;
      }
    }
  }
}

// What is kept is of one field: another, or the same with other samples, is drawn as it is.
TEST(FieldLevels, AreOfTheFieldThatIsDrawn) {
  OVOID_NIGHTLY_ON_DEVICE();
  const Index3 dims{64, 64, 64};
  const Look look = gray_look(0, 1, 0.5);
  const LatticeField bright = constant_field(dims, 0.9), dark = constant_field(dims, 0.2);
  Renderer renderer(tested_backend());
  for (const LatticeField* const field : {&bright, &dark, &bright}) {
    const TestScene scene = view_of(*field, 2, look);
    EXPECT_EQ(renderer.render({scene.field, scene.look}, scene.camera, scene.options).image.rgba,
              draw(scene).image.rgba);
  }
}

// A picture's opacity is over lengths of the data's spacing, whatever is drawn.
TEST(FieldLevels, KeepTheUnitDistance) {
  OVOID_NIGHTLY_ON_DEVICE();
  const LatticeField field = constant_field({64, 64, 64}, 0.5);
  TestScene scene = view_of(field, 2, uniform_look(0.02));
  const Pixel by_level = center_pixel(draw(scene).image);
  scene.options.post_convolution = PostConvolution::kOff;
  EXPECT_NEAR(by_level.a(), center_pixel(draw(scene).image).a(), 0.01);
  EXPECT_LT(by_level.a(), 0.9);
}

TEST(FieldLevels, StopWhileTheyAreMade) {
  OVOID_NIGHTLY_ON_DEVICE();
  const Index3 dims{64, 64, 64};
  const LatticeField field = make_field(dims, rings(dims));
  std::stop_source source;
  source.request_stop();
  FieldLevels levels;
  EXPECT_THROW(levels.at(field, 1, 2, source.get_token()), Error);
  EXPECT_EQ(levels.at(field, 1, 2, {}).lattice()->geometry().dims, (Index3{32, 32, 32}));
  EXPECT_EQ(levels.at(field, 0, 2, source.get_token()).id(), field.id());
  // They are made once, and of some fields at a time.
  const std::uint64_t once = levels.at(field, 1, 2, {}).id();
  levels.at(constant_field(dims, 1), 1, 2, {});
  EXPECT_EQ(levels.at(field, 1, 2, source.get_token()).id(), once);
}

}  // namespace field_levels_test
}  // namespace ovoid::test
