// SPDX-License-Identifier: Apache-2.0
// Depth limits: the back ends against the reference, and against what must come out.
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <string>

#include "ovoid/error.h"
#include "support/agreement.h"
#include "support/kernel_sets.h"
#include "support/scenes.h"
#include "support/tolerances.h"
#include "support/where.h"

namespace ovoid::test {
namespace depth_limits_test {

struct LimitedView {
  double isovalue;
  double fill;   // of the picture, as askew_camera()
  double reach;  // of the limits about the focal point
  ImageTolerance tolerance{};
};

void expect_agreement_in_every_mode(const Field& field, const LimitedView& view,
                                    const RenderOptions& options) {
  for (const Mode mode : {Mode::kComposite, Mode::kXray, Mode::kMaximum, Mode::kMinimum,
                          Mode::kMean, Mode::kIsosurface}) {
    for (const bool is_parallel : {true, false}) {
      for (const Classification how :
           {Classification::kRefined, Classification::kSampled, Classification::kPreintegrated}) {
        if (mode != Mode::kComposite && how != Classification::kRefined) continue;
        Look look = semi_transparent_look(field.value_range().lo, field.value_range().hi);
        look.mode = mode;
        look.isovalue = view.isovalue;
        TestScene scene{field, askew_camera(field, is_parallel, view.fill), look, options};
        scene.options.classification = how;
        scene.options.depth_limits = random_limits(scene, view.reach);
        ImageTolerance tolerance = view.tolerance;
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
  OVOID_NIGHTLY_ON_DEVICE();
  const KernelField field(jittered_ellipsoids(8).source(), Reconstruction::kNormalized);
  RenderOptions options = picture(50, 70, 0);
  options.post_convolution = PostConvolution::kOff;
  expect_agreement_in_every_mode(field, {.isovalue = 0.62, .fill = 1.3, .reach = 4}, options);
}

// The same of lattices, with samples from the kernels.
TEST(DepthLimits, AgreeForLattices) {
  OVOID_NIGHTLY_ON_DEVICE();
  const TestVolume volume = test_volumes()[0];
  RenderOptions options = picture(70, 50, 0);
  options.post_convolution = PostConvolution::kOff;
  const double middle = 0.5 * (volume.lo + volume.hi);
  expect_agreement_in_every_mode(volume.field, {.isovalue = middle, .fill = 1.3, .reach = 6},
                                 options);
}

// The same with samples from nodes, in a view from within, to the tier of such pictures.
TEST(DepthLimits, AgreeForMagnifiedLattices) {
  OVOID_NIGHTLY_ON_DEVICE();
  const TestVolume volume = test_volumes()[0];
  const double middle = 0.5 * (volume.lo + volume.hi);
  const ImageTolerance tier{.min_psnr_db = kLevelsPsnrDb, .max_8bit = 255};
  expect_agreement_in_every_mode(volume.field,
                                 {.isovalue = middle, .fill = 8, .reach = 3, .tolerance = tier},
                                 picture(50, 40, 0));
}

// Fails if planes and limits do not cut the same samples and pieces.
TEST(DepthLimits, AgreeWithClipPlanes) {
  OVOID_NIGHTLY_ON_DEVICE();
  const KernelField set(jittered_ellipsoids(8).source(), Reconstruction::kNormalized);
  const TestVolume volume = test_volumes()[0];
  for (const Field& field : {Field(set), Field(volume.field)}) {
    TestScene scene{field, askew_camera(field, false, 1.3),
                    semi_transparent_look(field.value_range().lo, field.value_range().hi),
                    picture(50, 40, 0)};
    scene.options.post_convolution = PostConvolution::kOff;
    const Vec3 normal(0.3, -0.2, 0.9);
    scene.options.clip_planes = {{normal, normal.dot(field.world_bounds().center())}};
    scene.options.depth_limits = random_limits(scene, 5);
    for (const Classification how :
         {Classification::kRefined, Classification::kSampled, Classification::kPreintegrated}) {
      scene.options.classification = how;
      EXPECT_TRUE(backends_agree(scene, "way " + std::to_string(static_cast<int>(how))));
    }
    scene.look.mode = Mode::kIsosurface;
    scene.look.isovalue = 0.5 * (field.value_range().lo + field.value_range().hi);
    EXPECT_TRUE(backends_agree(scene, "isosurface"));
  }
}

// Fails if what there is of a piece with one end does not reach to a limit on its other side:
// sheets are so far apart that half a piece is much.
TEST(DepthLimits, PiecesOfSetsReachToThem) {
  OVOID_NIGHTLY_ON_DEVICE();
  const KernelField field(jittered_ellipsoids(8).source(), Reconstruction::kNormalized);
  TestScene scene{field, askew_camera(field, false, 1.3), semi_transparent_look(0, 1),
                  picture(50, 70, 0)};
  scene.options.post_convolution = PostConvolution::kOff;
  scene.options.sampling_distance = 6 * field.default_sampling_distance();
  scene.options.depth_limits = random_limits(scene, 5);
  EXPECT_TRUE(backends_agree(scene, "half pieces", 0.05, {.min_psnr_db = 90}));
}

// A frame whose stops are before everything and let the field through is the frame without any.
TEST(DepthLimits, ThatLimitNothingChangeNothing) {
  OVOID_NIGHTLY_ON_DEVICE();
  const KernelField set(jittered_ellipsoids(8).source(), Reconstruction::kNormalized);
  const TestVolume volume = test_volumes()[0];
  for (const Field& field : {Field(set), Field(volume.field)}) {
    TestScene scene{field, askew_camera(field, false, 1.3),
                    semi_transparent_look(field.value_range().lo, field.value_range().hi),
                    picture(50, 70, 0)};
    scene.options.post_convolution = PostConvolution::kOff;
    scene.options.sheets = Sheets::kImage;
    const Image whole = draw(scene).image;
    auto limits = std::make_shared<DepthLimits>();
    limits->width = 50;
    limits->height = 70;
    limits->first = {0};
    for (std::uint32_t i = 1; i <= 50 * 70; ++i) {
      limits->stops.push_back({-std::numeric_limits<float>::infinity(), true, {}});
      limits->first.push_back(i);
    }
    scene.options.depth_limits = limits;
    EXPECT_GE(psnr(draw(scene).image, whole), 100);
  }
}

// Spans that begin just before a sheet, on it or just behind, of the next sheet in the next pixel,
// and end after a part of a piece, a piece, a block or never. Stops on sheets are seams, without a
// colour: which of the two comes first is nobody's to say.
std::shared_ptr<const DepthLimits> limits_at_every_sheet(const TestScene& scene) {
  constexpr int kSheets = 40;  // more than two blocks of a lattice, ten of a kernel set
  const double middle = (scene.camera.focal_point - scene.camera.position).norm();
  const double sheet = scene.options.sampling_distance;
  auto limits = std::make_shared<DepthLimits>();
  limits->width = scene.options.width;
  limits->height = scene.options.height;
  limits->first.push_back(0);
  for (int y = 0; y < limits->height; ++y) {
    for (int x = 0; x < limits->width; ++x) {
      const int side = y % 3 - 1;
      const auto add_stop = [&](double place, bool is_field_behind) {
        DepthLimits::Stop stop{static_cast<float>(middle + place * sheet), is_field_behind};
        stop.is_seam = side == 0;
        if (!stop.is_seam) stop.rgba = {0.1F, 0, 0.05F, 0.1F};
        limits->stops.push_back(stop);
      };
      // In sheets from the focal depth, which lies halfway between two.
      const double begin = x % kSheets - kSheets / 2 + 0.5 + 0.01 * side;
      add_stop(begin, true);
      if (y % 5 < 4) {
        const double lengths[] = {0.3, 1, 4, 16};
        const double end = begin + lengths[y % 5];
        add_stop(end, false);
        add_stop(end + 18, true);
      }
      limits->first.push_back(static_cast<std::uint32_t>(limits->stops.size()));
    }
  }
  return limits;
}

// Fails if a block of samples is left out that a span reaches, or a group of pixels is drawn as if
// no stop were in it.
TEST(DepthLimits, AgreeWhereverStopsLieInBlocks) {
  OVOID_NIGHTLY_ON_DEVICE();
  const KernelField set(jittered_ellipsoids(8).source(), Reconstruction::kNormalized);
  const TestVolume volume = test_volumes()[0];
  for (const Field& field : {Field(set), Field(volume.field)}) {
    for (const Mode mode : kModes) {
      for (const Classification how : {Classification::kRefined, Classification::kSampled}) {
        if (mode != Mode::kComposite && how != Classification::kRefined) continue;
        const ValueRange range = field.value_range();
        TestScene scene{field, askew_camera(field, false, 1.3),
                        semi_transparent_look(range.lo, range.hi), picture(70, 50, 0)};
        scene.look.mode = mode;
        scene.look.isovalue = 0.5 * (range.lo + range.hi);
        scene.options.classification = how;
        scene.options.post_convolution = PostConvolution::kOff;
        scene.options.sampling_distance = 0.5 * field.default_sampling_distance();
        scene.options.depth_limits = limits_at_every_sheet(scene);
        ImageTolerance tolerance;
        if (mode == Mode::kXray)
          tolerance.peak = greatest_color(draw(scene, Backend::kReference).image);
        EXPECT_TRUE(backends_agree(scene,
                                   "mode " + std::to_string(static_cast<int>(mode)) + ", way " +
                                       std::to_string(static_cast<int>(how)),
                                   0.05, tolerance));
      }
    }
  }
}

// Fails if colours of stops are lost where no field is drawn, or hidden ones show.
TEST(DepthLimits, StopsJoinFrontToBack) {
  OVOID_NIGHTLY_ON_DEVICE();
  const KernelField field(jittered_ellipsoids(4).source(), Reconstruction::kNormalized);
  TestScene scene{field, askew_camera(field, true, 1.3), semi_transparent_look(0, 1),
                  picture(40, 40, 0)};
  auto limits = std::make_shared<DepthLimits>();
  limits->width = limits->height = 40;
  limits->first = {0};
  for (std::uint32_t i = 1; i <= 40 * 40; ++i) {
    limits->stops.push_back({1, false, false, {0.25F, 0, 0, 0.25F}});
    limits->stops.push_back({2, false, false, {0, 1, 0, 1}});
    limits->stops.push_back({3, false, false, {1, 1, 1, 1}});
    limits->first.push_back(3 * i);
  }
  scene.options.depth_limits = limits;
  for (const Backend backend : {tested_backend(), Backend::kReference}) {
    const Image image = draw(scene, backend).image;
    for (std::size_t i = 0; i < image.depth.size(); ++i) {
      ASSERT_FLOAT_EQ(image.rgba[4 * i], 0.25F);
      ASSERT_FLOAT_EQ(image.rgba[4 * i + 1], 0.75F);
      ASSERT_FLOAT_EQ(image.rgba[4 * i + 2], 0);
      ASSERT_FLOAT_EQ(image.rgba[4 * i + 3], 1);
      ASSERT_FLOAT_EQ(image.depth[i], 2);
      ASSERT_FLOAT_EQ(image.front_depth[i], 1);
    }
  }
}

TEST(DepthLimits, AreRefusedWhereTheyDoNotFit) {
  OVOID_NIGHTLY_ON_DEVICE();
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
  OVOID_NIGHTLY_ON_DEVICE();
  const TestVolume volume = test_volumes()[0];
  TestScene scene{volume.field, askew_camera(volume.field, true, 1.3),
                  semi_transparent_look(volume.lo, volume.hi), picture(20, 20)};
  scene.options.depth_limits = random_limits(scene, 6);
  EXPECT_NO_THROW(draw(scene, Backend::kCpu));
  scene.options.sheets = Sheets::kLattice;
  EXPECT_THROW(draw(scene, Backend::kCpu), Error);
}

}  // namespace depth_limits_test
}  // namespace ovoid::test
