// SPDX-License-Identifier: Apache-2.0
// What only a back end on a device of its own can get wrong: what it keeps between frames, fields
// larger than its memory, and its ways to fail. Runs where OVOID_TEST_BACKEND names vulkan.
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <string>

#include "ovoid/devices.h"
#include "ovoid/error.h"
#include "support/agreement.h"
#include "support/kernel_sets.h"
#include "support/scenes.h"
#include "support/where.h"

namespace ovoid::test {
namespace device_test {

class OnDevice : public ::testing::Test {
 protected:
  void SetUp() override {
    if (tested_backend() != Backend::kVulkan) GTEST_SKIP() << "another back end is tested";
  }

  static Frame draw_with(const RendererSetup& setup, const TestScene& scene) {
    return Renderer(setup).render({scene.field, scene.look}, scene.camera, scene.options);
  }
};

TestScene lattice_scene(bool is_parallel) {
  const Index3 dims{40, 36, 44};
  TestScene scene;
  scene.field = make_stored_field(dims, shells(dims), {ScalarType::kUInt8, 0, 255});
  scene.camera = askew_camera(scene.field, is_parallel, 1.3);
  scene.look = semi_transparent_look(0, 255);
  scene.options = picture(40, 36);
  scene.options.post_convolution = PostConvolution::kOff;
  return scene;
}

// Of memory: its 63360 samples of a byte are cut into some boxes, and into small ones.
constexpr std::uint64_t kFewBoxes = std::uint64_t{48} << 10;
constexpr std::uint64_t kManyBoxes = std::uint64_t{36} << 10;

TestScene kernel_scene() {
  TestScene scene;
  scene.field = KernelField(jittered_ellipsoids(12).source(), Reconstruction::kNormalized);
  scene.camera = askew_camera(scene.field, false, 1.3);
  scene.look = semi_transparent_look(0, 1);
  scene.options = picture(56, 44);
  return scene;
}

void expect_same_bytes(const Image& a, const Image& b, const char* what) {
  EXPECT_TRUE(a.rgba == b.rgba) << what << ": other colours";
  EXPECT_TRUE(a.depth == b.depth && a.front_depth == b.front_depth) << what << ": other depths";
}

ErrorCode code_of(const std::function<void()>& work, std::string& message) {
  try {
    work();
  } catch (const Error& error) {
    message = error.what();
    return error.code();
  }
  return ErrorCode::kCancelled;
}

// Fails if boxes overlap or leave gaps, come in the wrong order, or lack samples that kernels
// reach.
TEST_F(OnDevice, LatticesLargerThanMemoryAreDrawnBoxByBox) {
  for (const bool is_parallel : {true, false}) {
    const TestScene scene = lattice_scene(is_parallel);
    const Frame whole = draw_with({.backend = Backend::kVulkan}, scene);
    for (const std::uint64_t bytes : {kFewBoxes, kManyBoxes}) {
      const Frame in_boxes =
          draw_with({.backend = Backend::kVulkan, .device_memory = bytes}, scene);
      expect_same_bytes(in_boxes.image, whole.image, is_parallel ? "parallel" : "perspective");
      // Boxes have samples in common.
      EXPECT_GT(in_boxes.profile.bytes_uploaded, whole.profile.bytes_uploaded);
    }
  }
}

// Fails if surfaces, pieces or differences end where one box does.
TEST_F(OnDevice, WhatLiesBetweenSheetsIsWholeAcrossBoxes) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (int way = 0; way < 4; ++way) {
    TestScene scene = lattice_scene(false);
    if (way == 3) {
      scene.camera = askew_camera(scene.field, false, 6);
      scene.options.post_convolution = PostConvolution::kCubic;
    }
    if (way == 0) scene.look.mode = Mode::kIsosurface;
    scene.look.isovalue = 120;
    if (way == 1) scene.options.classification = Classification::kPreintegrated;
    if (way == 2) scene.options.gradient = GradientMethod::kCentral;
    const Frame whole = draw_with({.backend = Backend::kVulkan}, scene);
    const Frame in_boxes =
        draw_with({.backend = Backend::kVulkan, .device_memory = kFewBoxes}, scene);
    const std::string what = "between sheets, way " + std::to_string(way);
    expect_same_bytes(in_boxes.image, whole.image, what.c_str());
    EXPECT_GT(in_boxes.profile.bytes_uploaded, whole.profile.bytes_uploaded);
  }
}

// Fails if a field and what is behind it are cut into other boxes.
TEST_F(OnDevice, TrailsGoThroughTheSameBoxes) {
  const TestScene scene = lattice_scene(false);
  const Index3 dims = scene.lattice().geometry().dims;
  const VolumeFunction later = [shape = shells(dims)](std::int64_t i, std::int64_t j,
                                                      std::int64_t k) {
    return 1 - shape(i, j, k);
  };
  const Trail trail{make_stored_field(dims, later, {ScalarType::kFloat32, 0, 255}),
                    scene.look.transfer_function};
  const auto draw_trail = [&](std::uint64_t bytes) {
    Renderer renderer(RendererSetup{.backend = Backend::kVulkan, .device_memory = bytes});
    return renderer.render(with_trail(scene.scene(), trail), scene.camera, scene.options).image;
  };
  const Image whole = draw_trail(0);
  EXPECT_FALSE(whole.rgba == draw(scene).image.rgba);
  expect_same_bytes(draw_trail(std::uint64_t{320} << 10), whole, "trail");
}

// Fails if a page's kernels are taken for another's, an evicted page for a resident one, or a brick
// is left out of rows or layers that it reaches.
TEST_F(OnDevice, SetsLargerThanMemoryAreDrawnPageByPage) {
  TestScene scene = kernel_scene();
  scene.field = KernelField(jittered_ellipsoids(24).source(), Reconstruction::kNormalized);
  scene.options = picture(80, 160);
  scene.options.post_convolution = PostConvolution::kOff;
  const Image whole = draw(scene).image;
  // Of the 13824 kernels 11520 at a time: of one layer there are more, so it has fewer rows.
  const Frame in_pages =
      draw_with({.backend = Backend::kVulkan, .device_memory = 720U << 10U}, scene);
  expect_same_bytes(in_pages.image, whole, "pages");
}

// Fails if a frame leaves something behind that the next one reads, or sends the field again.
TEST_F(OnDevice, FieldsStayAndFramesRepeat) {
  Renderer renderer(RendererSetup{.backend = Backend::kVulkan});
  for (const TestScene& scene : {lattice_scene(false), kernel_scene()}) {
    const auto render = [&](const Look& look) {
      return renderer.render({scene.field, look}, scene.camera, scene.options);
    };
    const Frame first = render(scene.look);
    Look other = scene.look;
    other.transfer_function.opacities.back().opacity = 0.9;
    const Frame changed = render(other);
    const Frame again = render(scene.look);
    expect_same_bytes(again.image, first.image, "repeated");
    EXPECT_FALSE(changed.image.rgba == first.image.rgba);
    EXPECT_LT(changed.profile.bytes_uploaded, first.profile.bytes_uploaded);
    // A look and its tables, not the field.
    const auto field_bytes = static_cast<std::int64_t>(scene.field.resident_bytes());
    EXPECT_LE(changed.profile.bytes_uploaded, first.profile.bytes_uploaded - field_bytes / 2);
  }
}

Look unlit(Look look) {
  look.shade = false;
  return look;
}

// A logarithmic ramp over six decades.
Look logarithmic_look(double greatest) {
  Look look = unlit(ramp_look({static_cast<float>(1e-6 * greatest), static_cast<float>(greatest)}));
  look.transfer_function.scale = ValueScale::kLog;
  return look;
}

// Fails if 16 bits are taken where they can be seen, lit or not, or nothing is said where they are
// not, or if they are never taken.
TEST_F(OnDevice, HalfSheetsKeepTheirTierOnSets) {
  OVOID_NIGHTLY_ON_DEVICE();
  const KernelField wide(balls_of_all_sizes(600, 1e-3).source(), Reconstruction::kSum);
  for (const KernelField& field :
       {KernelField(jittered_ellipsoids(9).source(), Reconstruction::kNormalized),
        KernelField(jittered_ellipsoids(9).source(), Reconstruction::kSum), wide}) {
    std::vector<TestLook> looks = test_looks(0, field.value_range().hi);
    for (std::size_t i = 0, lit = looks.size(); i < lit; ++i)
      looks.push_back({looks[i].name + ", unlit", unlit(looks[i].look)});
    looks.push_back({"logarithmic", logarithmic_look(field.value_range().hi)});
    int num_taken = 0;
    for (const TestLook& look : looks) {
      TestScene scene = kernel_scene();
      scene.field = field;
      scene.camera = askew_camera(field, false, 1.3);
      scene.look = look.look;
      scene.options.classification =
          Classification::kSampled;  // refined pieces have a test of theirs
      const Frame whole = draw(scene);
      EXPECT_EQ(whole.profile.notice, "");
      scene.options.sheet_precision = SheetPrecision::kHalf;
      const Frame half = draw(scene);
      const ImageDifference lost = compare(half.image, whole.image);
      EXPECT_GE(lost.psnr_db, kHalfSheetsPsnrDb) << look.name << ": " << lost.to_string();
      EXPECT_LE(lost.max_8bit, kHalfSheets8BitDifference) << look.name << ": " << lost.to_string();
      EXPECT_GT(lost.num_covered, 10) << look.name;
      EXPECT_EQ(half.profile.notice.empty(), half.image.rgba != whole.image.rgba) << look.name;
      EXPECT_TRUE(!look.look.shade || !half.profile.notice.empty()) << look.name;
      num_taken += half.profile.notice.empty() ? 1 : 0;
    }
    EXPECT_GE(num_taken, 2);
  }
}

// Fails if what a lattice never keeps is rounded all the same, or nothing is said of it.
TEST_F(OnDevice, HalfSheetsAreNotForLattices) {
  TestScene scene = lattice_scene(false);
  const Image whole = draw(scene).image;
  scene.options.sheet_precision = SheetPrecision::kHalf;
  const Frame half = draw(scene);
  expect_same_bytes(half.image, whole, "half sheets of a lattice");
  EXPECT_NE(half.profile.notice.find("of lattices no sheets are kept"), std::string::npos);
}

// Fails if what a switch leaves out is not what cannot be seen.
TEST_F(OnDevice, SwitchesChangeTimeAlone) {
  for (TestScene scene : {lattice_scene(false), kernel_scene()}) {
    const double lo = scene.look.transfer_function.lo();
    const double span = scene.look.transfer_function.hi() - lo;
    scene.look.transfer_function.opacities = {{lo + 0.2 * span, 0}, {lo + 0.3 * span, 1}};
    scene.options.sampling_distance = 0.4 * scene.field.default_sampling_distance();
    const Frame plain = draw(scene);
    for (bool RenderOptions::*const of :
         {&RenderOptions::skip_irrelevant, &RenderOptions::stop_opaque,
          &RenderOptions::pack_sheets}) {
      scene.options.*of = false;
      expect_same_bytes(draw(scene).image, plain.image, "switched off");
      scene.options.*of = true;
    }
    scene.options.stop_opaque = false;
    EXPECT_GT(draw(scene).profile.samples_reconstructed, plain.profile.samples_reconstructed);
  }
}

TEST_F(OnDevice, StagesAreTimedAndTheDeviceIsNamed) {
  TestScene scene = kernel_scene();
  scene.options.collect_profile = true;
  const FrameProfile profile = draw(scene).profile;
  EXPECT_EQ(profile.backend, "vulkan");
  EXPECT_FALSE(profile.device.empty());
  std::vector<std::string> stages;
  for (const auto& [stage, ms] : profile.stages_ms) {
    stages.push_back(stage);
    EXPECT_GE(ms, 0) << stage;
  }
  for (const char* const stage : {"project", "sort", "reconstruct", "shade and composite"})
    EXPECT_NE(std::find(stages.begin(), stages.end(), stage), stages.end()) << stage;
}

TEST_F(OnDevice, StopsAndTellsOfProgress) {
  TestScene scene = lattice_scene(true);
  scene.options.height = 300;
  std::stop_source stop;
  RenderHooks hooks;
  hooks.stop = stop.get_token();
  std::vector<double> told;
  hooks.progress = [&](double fraction) {
    told.push_back(fraction);
    stop.request_stop();
  };
  Renderer renderer(RendererSetup{.backend = Backend::kVulkan});
  std::string message;
  EXPECT_EQ(code_of(
                [&] {
                  renderer.render({scene.field, scene.look}, scene.camera, scene.options, hooks);
                },
                message),
            ErrorCode::kCancelled);
  EXPECT_EQ(message, "rendering was cancelled");
  ASSERT_EQ(told.size(), 1U);
  EXPECT_GT(told.front(), 0);
  EXPECT_LT(told.front(), 1);
  // And goes on with the next, the field still there.
  scene.options.height = 36;
  const Frame next = renderer.render({scene.field, scene.look}, scene.camera, scene.options);
  expect_same_bytes(next.image, draw(scene).image, "after a stop");
  Look other = scene.look;
  other.transfer_function.opacities.back().opacity = 0.9;
  EXPECT_LT(
      renderer.render({scene.field, other}, scene.camera, scene.options).profile.bytes_uploaded,
      draw_with({.backend = Backend::kVulkan}, scene).profile.bytes_uploaded);
}

TEST_F(OnDevice, ImpossibleWishesAreErrorsWithAWayOut) {
  std::string message;
  const int count = static_cast<int>(list_devices().devices.size());
  EXPECT_EQ(code_of([&] { Renderer(RendererSetup{.backend = Backend::kVulkan, .device = count}); },
                    message),
            ErrorCode::kInvalidArgument);
  EXPECT_NE(message.find("device = "), std::string::npos) << message;
  EXPECT_EQ(
      code_of([&] { Renderer(RendererSetup{.backend = Backend::kVulkan, .device = -2}); }, message),
      ErrorCode::kInvalidArgument);
  EXPECT_EQ(code_of(
                [&] {
                  draw_with({.backend = Backend::kVulkan, .device_memory = 512},
                            lattice_scene(true));
                },
                message),
            ErrorCode::kOutOfMemory);
  EXPECT_NE(message.find("backend cpu"), std::string::npos) << message;
}

// Fails if a pixel forgets in the next box or dispatch which stops have joined it.
TEST_F(OnDevice, DepthLimitsGoThroughBoxes) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (int way = 0; way < 4; ++way) {
    TestScene scene = lattice_scene(false);
    scene.options.classification = way == 0   ? Classification::kRefined
                                   : way == 1 ? Classification::kPreintegrated
                                              : Classification::kSampled;
    if (way == 2) scene.look.mode = Mode::kXray;
    if (way == 3) scene.look.mode = Mode::kIsosurface;
    scene.look.isovalue = 120;
    scene.options.depth_limits = random_limits(scene, 15);
    const Frame whole = draw_with({.backend = Backend::kVulkan}, scene);
    const Frame in_boxes =
        draw_with({.backend = Backend::kVulkan, .device_memory = kFewBoxes}, scene);
    expect_same_bytes(in_boxes.image, whole.image, "limits in boxes");
    EXPECT_GT(in_boxes.profile.bytes_uploaded, whole.profile.bytes_uploaded);
  }
}

// The same of a set's layers, whose rows are drawn anew, fewer at a time, where they do not fit.
TEST_F(OnDevice, DepthLimitsGoThroughPages) {
  TestScene scene = kernel_scene();
  scene.field = KernelField(jittered_ellipsoids(24).source(), Reconstruction::kNormalized);
  scene.options = picture(80, 160);
  scene.options.post_convolution = PostConvolution::kOff;
  scene.options.depth_limits = random_limits(scene, 15);
  const Image whole = draw(scene).image;
  const Frame in_pages =
      draw_with({.backend = Backend::kVulkan, .device_memory = 720U << 10U}, scene);
  expect_same_bytes(in_pages.image, whole, "limits in pages");
}

// Fails if rows that are drawn later take the limits of others.
TEST_F(OnDevice, DepthLimitsAreThoseOfTheirRows) {
  for (TestScene scene : {lattice_scene(true), kernel_scene()}) {
    scene.options.height = 300;
    scene.options.depth_limits = random_limits(scene, 8);
    const Image whole = draw(scene).image;
    RenderHooks hooks;
    int num_strips = 0;
    hooks.tile_done = [&](const auto&) { ++num_strips; };
    Renderer renderer(RendererSetup{.backend = Backend::kVulkan});
    const Frame watched =
        renderer.render({scene.field, scene.look}, scene.camera, scene.options, hooks);
    expect_same_bytes(watched.image, whole, "limits in strips");
    EXPECT_EQ(num_strips > 1, list_devices().devices[0].kind == DeviceKind::kSoftware);
  }
}

// Fails if stops that a buffer of 128 MiB does not hold are cut off. All but the last stop of a
// pixel let the field through, from the same place.
TEST_F(OnDevice, MoreDepthLimitsThanABufferHoldsAreDrawnInBands) {
  OVOID_NIGHTLY_ON_DEVICE();
  TestScene scene = kernel_scene();
  scene.options.width = 512;
  scene.options.height = 256;
  const auto limits_of = [&](std::uint32_t stops_per_pixel) {
    auto limits = std::make_shared<DepthLimits>();
    limits->width = scene.options.width;
    limits->height = scene.options.height;
    const auto num_pixels = static_cast<std::uint32_t>(limits->width * limits->height);
    for (std::uint32_t pixel = 0; pixel <= num_pixels; ++pixel)
      limits->first.push_back(pixel * stops_per_pixel);
    limits->stops.assign(std::size_t{num_pixels} * stops_per_pixel,
                         {-std::numeric_limits<float>::infinity(), true, {}});
    const auto middle =
        static_cast<float>((scene.camera.focal_point - scene.camera.position).norm());
    for (std::uint32_t pixel = 1; pixel <= num_pixels; ++pixel)
      limits->stops[limits->first[pixel] - 1] = {middle, false, false, {0, 0.5F, 0.5F, 1}};
    return limits;
  };
  scene.options.depth_limits = limits_of(2);
  const Image few = draw(scene).image;
  scene.options.depth_limits = limits_of(48);
  expect_same_bytes(draw(scene).image, few, "limits in bands");
}

// Fails if what a switch leaves out takes stops with it.
TEST_F(OnDevice, SwitchesLeaveDepthLimitsAlone) {
  for (TestScene scene : {lattice_scene(false), kernel_scene()}) {
    const double lo = scene.look.transfer_function.lo();
    const double span = scene.look.transfer_function.hi() - lo;
    scene.look.transfer_function.opacities = {{lo + 0.4 * span, 0}, {lo + 0.6 * span, 1}};
    scene.options.depth_limits = random_limits(scene, 8);
    const Frame plain = draw(scene);
    for (bool RenderOptions::*const of :
         {&RenderOptions::skip_irrelevant, &RenderOptions::stop_opaque}) {
      scene.options.*of = false;
      expect_same_bytes(draw(scene).image, plain.image, "switched off");
      scene.options.*of = true;
    }
  }
}

// Fails if what auto takes a device for is left to the cpu.
TEST_F(OnDevice, AutoDrawsDepthLimits) {
  TestScene scene = lattice_scene(true);
  scene.options.depth_limits = random_limits(scene, 15);
  const Frame frame = draw_with({.auto_takes_software = true}, scene);
  EXPECT_EQ(frame.profile.backend, "vulkan");
  EXPECT_EQ(frame.profile.notice, "");
}

// Fails if a software driver's loops end early in a pixel of many stops, and nobody is told.
TEST_F(OnDevice, SoftwareDriversRefuseTooManyStops) {
  if (list_devices().devices[0].kind != DeviceKind::kSoftware) GTEST_SKIP() << "hardware";
  for (TestScene scene : {lattice_scene(true), kernel_scene()}) {
    auto limits = std::make_shared<DepthLimits>();
    limits->width = scene.options.width;
    limits->height = scene.options.height;
    limits->first.assign(static_cast<std::size_t>(limits->width * limits->height) + 1, 0);
    limits->first.back() = 1000;
    limits->stops.assign(1000, {0, true, {}});
    scene.options.depth_limits = limits;
    std::string message;
    EXPECT_EQ(code_of([&] { draw_with({.backend = Backend::kVulkan}, scene); }, message),
              ErrorCode::kUnsupported);
    EXPECT_NE(message.find("limits"), std::string::npos) << message;
  }
}

}  // namespace device_test
}  // namespace ovoid::test
