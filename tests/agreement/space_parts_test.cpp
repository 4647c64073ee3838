// SPDX-License-Identifier: Apache-2.0
// Pictures put together of what parts of space show, against the picture of the whole.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <string>

#include "ovoid/error.h"
#include "support/agreement.h"
#include "support/kernel_sets.h"
#include "support/scenes.h"
#include "support/where.h"

namespace ovoid::test {
namespace space_parts_test {

// Software drivers take seconds for each picture.
std::vector<int> counts() {
  if (tested_backend() == Backend::kVulkan) return {3};
  return {1, 2, 3, 4, 7};
}

// Of each of `count` parts, in an order that is none.
std::vector<DeepImage> seen_by_parts(TestScene scene, int count) {
  std::vector<SpacePart> parts = split_space(scene.field, count);
  std::shuffle(parts.begin(), parts.end(), std::mt19937(5));
  std::vector<DeepImage> seen;
  for (const SpacePart& part : parts) {
    scene.options.part = std::make_shared<SpacePart>(part);
    seen.push_back(*draw(scene).seen);
  }
  return seen;
}

// A 255th at most at any pixel, and a quarter of that at all but a few.
void expect_whole(const Image& together, const Image& whole, const std::string& name,
                  double peak = 1) {
  const ImageDifference difference = compare(together, whole, peak);
  EXPECT_GT(difference.num_covered, whole.width * whole.height / 20) << name;
  EXPECT_LE(difference.max_float, 1.0 / 255) << name << ": " << difference.to_string();
  EXPECT_LE(difference.p999, 0.25 / 255) << name << ": " << difference.to_string();
}

// Fails if parts do not divide all pieces of all rays among them, or draw them otherwise.
void expect_parts_to_make_the_whole(TestScene scene, const std::string& name) {
  scene.options.sheets = Sheets::kImage;
  const Image whole = draw(scene).image;
  const double peak = scene.look.mode == Mode::kXray ? greatest_color(whole) : 1;
  for (const int count : counts())
    expect_whole(composited(merged(seen_by_parts(scene, count)), scene.look), whole,
                 name + ", parts " + std::to_string(count), peak);
}

void expect_parts_in_every_mode(const Field& field, double isovalue, const RenderOptions& options,
                                double fill) {
  for (const Mode mode : kModes) {
    for (const bool is_parallel : {true, false}) {
      if (is_left_out(static_cast<int>(mode), is_parallel ? 1 : 0)) continue;
      Look look = semi_transparent_look(field.value_range().lo, field.value_range().hi);
      look.mode = mode;
      look.isovalue = isovalue;
      expect_parts_to_make_the_whole({field, askew_camera(field, is_parallel, fill), look, options},
                                     std::string(kModeNames[static_cast<int>(mode)]) +
                                         (is_parallel ? ", parallel" : ", perspective"));
    }
  }
}

TEST(SpaceParts, MakeTheWholeOfLattices) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NIGHTLY_ON_DEVICE();
  const TestVolume volume = test_volumes()[1];
  expect_parts_in_every_mode(volume.field, 0.5 * (volume.lo + volume.hi), picture(70, 50, 0), 1.3);
}

TEST(SpaceParts, MakeTheWholeOfLatticesWithHoles) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NIGHTLY_ON_DEVICE();
  const TestVolume volume = test_volumes()[2];
  expect_parts_in_every_mode(volume.field, 0.5 * (volume.lo + volume.hi), picture(50, 40, 0), 1.3);
}

TEST(SpaceParts, MakeTheWholeOfMagnifiedLattices) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NIGHTLY_ON_DEVICE();
  const TestVolume volume = test_volumes()[0];
  expect_parts_in_every_mode(volume.field, 0.5 * (volume.lo + volume.hi), picture(90, 70, 0), 6);
}

TEST(SpaceParts, MakeTheWholeOfKernelSets) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NIGHTLY_ON_DEVICE();
  const KernelField field(jittered_ellipsoids(8).source(), Reconstruction::kNormalized);
  expect_parts_in_every_mode(field, 0.62, picture(90, 70, 0), 1.3);
}

TEST(SpaceParts, MakeTheWholeOfBallsOfAllSizes) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NIGHTLY_ON_DEVICE();
  const KernelField field(balls_of_all_sizes(3000, 0.002).source(), Reconstruction::kSum);
  expect_parts_in_every_mode(field, 0.3, picture(100, 80, 0), 1.2);
}

TEST(SpaceParts, MakeTheWholeHoweverClassified) {
  OVOID_NIGHTLY_ON_DEVICE();
  const KernelField set(jittered_ellipsoids(8).source(), Reconstruction::kNormalized);
  const TestVolume volume = test_volumes()[0];
  for (const Field& field : {Field(set), Field(volume.field)}) {
    for (const Classification how : {Classification::kSampled, Classification::kPreintegrated}) {
      TestScene scene{field, askew_camera(field, false, 1.3),
                      semi_transparent_look(field.value_range().lo, field.value_range().hi),
                      picture(60, 50, 0)};
      scene.options.classification = how;
      expect_parts_to_make_the_whole(scene, "way " + std::to_string(static_cast<int>(how)));
    }
  }
}

// Opaque surfaces inside, so that parts behind others are hidden; light that all of the field
// changes; a cut.
TEST(SpaceParts, MakeTheWholeInLightAndShadow) {
  OVOID_NIGHTLY_ON_DEVICE();
  const KernelField set(jittered_ellipsoids(8).source(), Reconstruction::kNormalized);
  const TestVolume volume = test_volumes()[0];
  for (const Field& field : {Field(set), Field(volume.field)}) {
    const ValueRange range = field.value_range();
    TestScene scene{field, askew_camera(field, false, 1.3), test_looks(range.lo, range.hi)[2].look,
                    picture(60, 50, 0)};
    scene.look.occlusion = 0.6;
    scene.look.shadows = 0.7;
    const Vec3 normal(0.3, -0.2, 0.9);
    scene.options.clip_planes = {{normal, normal.dot(field.world_bounds().center())}};
    expect_parts_to_make_the_whole(scene, "in light");
  }
}

// Fails if stops and coverage are taken by several parts or by none, or pieces that have one end
// reach out to a seam.
TEST(SpaceParts, MakeTheWholeWithinLimits) {
  OVOID_NIGHTLY_ON_DEVICE();
  const KernelField set(jittered_ellipsoids(8).source(), Reconstruction::kNormalized);
  const TestVolume volume = test_volumes()[0];
  for (const Field& field : {Field(set), Field(volume.field)}) {
    for (const Mode mode : {Mode::kComposite, Mode::kMean}) {
      TestScene scene{field, askew_camera(field, false, 1.3),
                      semi_transparent_look(field.value_range().lo, field.value_range().hi),
                      picture(60, 50, 0)};
      scene.look.mode = mode;
      scene.options.sampling_distance = 3 * field.default_sampling_distance();
      scene.options.depth_limits = random_limits(scene, 6);
      expect_parts_to_make_the_whole(scene, "within limits");
    }
  }
}

// Fails if who draws two parts that do not touch cannot say so.
TEST(SpaceParts, MayBeSharedOutAnyhow) {
  const TestVolume volume = test_volumes()[1];
  TestScene scene{Field(volume.field), askew_camera(Field(volume.field), false, 1.3),
                  semi_transparent_look(volume.lo, volume.hi), picture(70, 50, 0)};
  scene.options.sheets = Sheets::kImage;
  const std::vector<DeepImage> seen = seen_by_parts(scene, 12);
  std::vector<DeepImage> owners;
  for (std::size_t owner = 0; owner < 3; ++owner)
    owners.push_back(
        merged(std::vector{seen[owner], seen[owner + 3], seen[owner + 6], seen[owner + 9]}));
  EXPECT_EQ(merged(owners), merged(seen));
  expect_whole(composited(merged(owners), scene.look), draw(scene).image, "shared out");
}

TEST(SpaceParts, MakeTheWholeOfBallsThatAreDrawnAsSuch) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NIGHTLY_ON_DEVICE();
  const KernelField set(jittered_balls(6).source(), Reconstruction::kNormalized);
  TestScene scene{Field(set), askew_camera(Field(set), false, 1.3), semi_transparent_look(0, 1),
                  picture(90, 70, 0)};
  const auto drawn = [&] {
    Scene points = scene.scene();
    points.volumes.front().points = PointStyle();
    return Renderer(Backend::kCpu, 2).render(points, scene.camera, scene.options);
  };
  const Image whole = drawn().image;
  std::vector<DeepImage> seen;
  for (const SpacePart& part : split_space(scene.field, 5)) {
    scene.options.part = std::make_shared<SpacePart>(part);
    seen.push_back(*drawn().seen);
    EXPECT_LT(seen.back().runs.size(), static_cast<std::size_t>(whole.width * whole.height) / 2);
  }
  EXPECT_EQ(compare(composited(merged(seen), scene.look), whole).max_float, 0);
}

TEST(SpaceParts, SayWhatTheyAreNotFor) {
  OVOID_NIGHTLY_ON_DEVICE();
  const TestVolume volume = test_volumes()[0];
  TestScene scene{Field(volume.field), askew_camera(Field(volume.field), false, 1.3),
                  semi_transparent_look(volume.lo, volume.hi), picture(20, 20, 0)};
  scene.options.part = std::make_shared<SpacePart>();
  Renderer renderer(Backend::kCpu, 1);
  const Trail trail{volume.field, scene.look.transfer_function};
  EXPECT_THROW(renderer.render(with_trail(scene.scene(), trail), scene.camera, scene.options),
               Error);
  Scene cut = scene.scene();
  cut.plane = ValuePlane{{1, 0, 0}, 0};
  EXPECT_THROW(renderer.render(cut, scene.camera, scene.options), Error);
  scene.options.part = std::make_shared<SpacePart>(SpacePart{{{Vec3::Zero(), 0, true}}});
  EXPECT_THROW(draw(scene), Error);
  EXPECT_THROW(split_space(scene.field, 0), Error);
}

}  // namespace space_parts_test
}  // namespace ovoid::test
