// SPDX-License-Identifier: Apache-2.0
// Depth limits: the back ends against the reference, and against what must come out.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <random>

#include "ovoid/error.h"
#include "support/agreement.h"
#include "support/kernel_sets.h"
#include "support/scenes.h"

namespace ovoid::test {
namespace {

// Stops at random, about the focal distance; every ninth pixel has none.
std::shared_ptr<const DepthLimits> random_limits(const Scene& scene, double reach,
                                                 bool has_colors) {
  std::mt19937 engine(23);  // NOLINT(bugprone-random-generator-seed): the same every time
  std::uniform_real_distribution<float> share(0, 1);
  const auto middle = static_cast<float>((scene.camera.focal_point - scene.camera.position).norm());
  auto limits = std::make_shared<DepthLimits>();
  limits->width = scene.options.width;
  limits->height = scene.options.height;
  limits->first.push_back(0);
  const int num_pixels = limits->width * limits->height;
  for (int pixel = 0; pixel < num_pixels; ++pixel) {
    const int count = pixel % 9;
    std::vector<float> depths;
    for (int i = 0; i < count; ++i)
      depths.push_back(middle + static_cast<float>(reach) * (2 * share(engine) - 1));
    std::sort(depths.begin(), depths.end());
    if (count > 0 && pixel % 2 == 0) depths[0] = -std::numeric_limits<float>::infinity();
    for (int i = 0; i < count; ++i) {
      DepthLimits::Stop stop{depths[static_cast<std::size_t>(i)], i % 3 != 1, {}};
      if (has_colors && share(engine) < 0.5F) {
        const float opacity = share(engine) < 0.2F ? 1.0F : 0.5F * share(engine);
        stop.rgba = {opacity * share(engine), opacity * share(engine), opacity * share(engine),
                     opacity};
      }
      limits->stops.push_back(stop);
    }
    limits->first.push_back(static_cast<std::uint32_t>(limits->stops.size()));
    limits->coverage.push_back(pixel % 5 == 0 ? share(engine) : 1.0F);
  }
  return limits;
}

void expect_agreement_in_every_mode(const Field& field, double isovalue, double reach,
                                    const RenderOptions& options) {
  for (const Mode mode :
       {Mode::kComposite, Mode::kXray, Mode::kMaximum, Mode::kMean, Mode::kIsosurface}) {
    for (const bool is_parallel : {true, false}) {
      for (const Classification how :
           {Classification::kRefined, Classification::kSampled, Classification::kPreintegrated}) {
        if (mode != Mode::kComposite && how != Classification::kRefined) continue;
        Look look = semi_transparent_look(field.value_range().lo, field.value_range().hi);
        look.mode = mode;
        look.isovalue = isovalue;
        Scene scene{field, askew_camera(field, is_parallel, 1.3), look, options};
        scene.options.classification = how;
        scene.options.depth_limits = random_limits(scene, reach, true);
        ImageTolerance tolerance;
        if (mode == Mode::kXray)
          tolerance.peak = greatest_color(draw(scene, Backend::kReference).image);
        EXPECT_TRUE(backends_agree(scene,
                                   "mode " + std::to_string(static_cast<int>(mode)) + ", way " +
                                       std::to_string(static_cast<int>(how)) +
                                       (is_parallel ? ", parallel" : ", perspective"),
                                   0.05, tolerance));
      }
    }
  }
}

// Fails if a span, a stop's colour, an end of a piece or the depth is off.
TEST(DepthLimits, AgreeForKernelSets) {
  const KernelField field(jittered_ellipsoids(8).source(), Reconstruction::kNormalized);
  RenderOptions options = picture(50, 70, 0);
  options.post_convolution = PostConvolution::kOff;
  expect_agreement_in_every_mode(field, 0.62, 4, options);
}

// The same of lattices, with samples from the kernels and from nodes.
TEST(DepthLimits, AgreeForLattices) {
  const TestVolume volume = test_volumes()[0];
  for (const PostConvolution how : {PostConvolution::kOff, PostConvolution::kAuto}) {
    RenderOptions options = picture(70, 50, 0);
    options.post_convolution = how;
    const ValueRange range = volume.field.value_range();
    expect_agreement_in_every_mode(volume.field, 0.5 * (range.lo + range.hi), 6, options);
  }
}

// A frame whose stops are before everything and let the field through is the frame without any.
TEST(DepthLimits, ThatLimitNothingChangeNothing) {
  const KernelField field(jittered_ellipsoids(8).source(), Reconstruction::kNormalized);
  const Look look = semi_transparent_look(0, 1);
  Scene scene{field, askew_camera(field, false, 1.3), look, picture(50, 70, 0)};
  scene.options.post_convolution = PostConvolution::kOff;
  const Image whole = draw(scene, Backend::kCpu).image;
  auto limits = std::make_shared<DepthLimits>();
  limits->width = 50;
  limits->height = 70;
  limits->first = {0};
  for (std::uint32_t i = 1; i <= 50 * 70; ++i) {
    limits->stops.push_back({-std::numeric_limits<float>::infinity(), true, {}});
    limits->first.push_back(i);
  }
  scene.options.depth_limits = limits;
  EXPECT_GE(psnr(draw(scene, Backend::kCpu).image, whole), 100);
}

// Fails if colours of stops are lost where no field is drawn, or hidden ones show.
TEST(DepthLimits, StopsJoinFrontToBack) {
  const KernelField field(jittered_ellipsoids(4).source(), Reconstruction::kNormalized);
  Scene scene{field, askew_camera(field, true, 1.3), semi_transparent_look(0, 1),
              picture(40, 40, 0)};
  auto limits = std::make_shared<DepthLimits>();
  limits->width = limits->height = 40;
  limits->first = {0};
  for (std::uint32_t i = 1; i <= 40 * 40; ++i) {
    limits->stops.push_back({1, false, {0.25F, 0, 0, 0.5F}});
    limits->stops.push_back({2, false, {0, 1, 0, 1}});
    limits->stops.push_back({3, false, {1, 1, 1, 1}});
    limits->first.push_back(3 * i);
  }
  scene.options.depth_limits = limits;
  for (const Backend backend : {Backend::kCpu, Backend::kReference}) {
    const Image image = draw(scene, backend).image;
    for (std::size_t i = 0; i < image.depth.size(); ++i) {
      ASSERT_FLOAT_EQ(image.rgba[4 * i], 0.25F);
      ASSERT_FLOAT_EQ(image.rgba[4 * i + 1], 0.5F);
      ASSERT_FLOAT_EQ(image.rgba[4 * i + 2], 0);
      ASSERT_FLOAT_EQ(image.rgba[4 * i + 3], 1);
      ASSERT_FLOAT_EQ(image.depth[i], 1);
    }
  }
}

TEST(DepthLimits, AreRefusedWhereTheyDoNotFit) {
  DepthLimits limits;
  limits.width = 2;
  limits.height = 1;
  limits.first = {0, 2, 2};
  limits.stops = {{2, true, {}}, {1, false, {}}};
  EXPECT_THROW(limits.validate(), Error);  // not front to back
  limits.stops[1].depth = 3;
  EXPECT_NO_THROW(limits.validate());
  limits.coverage = {1, 2};
  EXPECT_THROW(limits.validate(), Error);
  limits.coverage.clear();
  limits.first = {0, 2};
  EXPECT_THROW(limits.validate(), Error);
}

// Lattice sheets have other pixels.
TEST(DepthLimits, AreRefusedOnLatticeSheets) {
  const TestVolume volume = test_volumes()[0];
  Scene scene{volume.field, askew_camera(volume.field, true, 1.3),
              semi_transparent_look(volume.lo, volume.hi), picture(20, 20)};
  scene.options.depth_limits = random_limits(scene, 6, false);
  EXPECT_NO_THROW(draw(scene, Backend::kCpu));
  scene.options.sheets = Sheets::kLattice;
  EXPECT_THROW(draw(scene, Backend::kCpu), Error);
}

}  // namespace
}  // namespace ovoid::test
