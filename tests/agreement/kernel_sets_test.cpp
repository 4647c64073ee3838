// SPDX-License-Identifier: Apache-2.0
// Kernel sets, the cpu back end against the reference.
#include <gtest/gtest.h>

#include <cmath>

#include "ovoid/crop.h"
#include "support/agreement.h"
#include "support/kernel_sets.h"
#include "support/scenes.h"
#include "support/where.h"

namespace ovoid::test {
namespace kernel_sets_test {

struct NamedKernelSet {
  std::string name;
  KernelNumbers numbers;
};

std::vector<NamedKernelSet> kernel_test_sets() {
  KernelNumbers far_away = jittered_ellipsoids(7);
  for (double& x : far_away.centers) x += 5e5;
  KernelNumbers spline = jittered_balls(8);
  spline.profile = KernelProfile::kCubicSpline;
  return {{"ellipsoids", jittered_ellipsoids(9)},
          {"stretched 30 to 1", jittered_ellipsoids(7, 5.5)},
          {"balls", jittered_balls(9)},
          {"far from the origin", far_away},
          {"cubic splines", spline}};
}

RenderOptions direct_options(int width, int height, double distance = 0) {
  RenderOptions options = picture(width, height, distance);
  options.post_convolution = PostConvolution::kOff;
  return options;
}

std::string view_text(bool is_parallel) { return is_parallel ? ", parallel" : ", perspective"; }

// Fails if a section, its rows, the widening, the skipping of blocks or the differences are off.
TEST(KernelSets, AgreeOnEverySetAndLook) {
  OVOID_NIGHTLY_ON_DEVICE();
  OVOID_NOT_UNDER_ASAN();
  for (const NamedKernelSet& set : kernel_test_sets()) {
    const KernelField field(set.numbers.source(), Reconstruction::kNormalized);
    for (const TestLook& look : test_looks(0, 1)) {
      for (const bool is_parallel : {true, false}) {
        const TestScene scene{field, askew_camera(field, is_parallel, is_parallel ? 1.0 : 1.6),
                              look.look, direct_options(72, 66)};
        EXPECT_TRUE(
            backends_agree(scene, set.name + ", " + look.name + view_text(is_parallel), 0.002));
      }
    }
  }
}

TEST(KernelSets, AgreeInEveryMode) {
  const KernelField field(jittered_ellipsoids(8).source(), Reconstruction::kNormalized);
  for (const Mode mode :
       {Mode::kXray, Mode::kMaximum, Mode::kMinimum, Mode::kMean, Mode::kIsosurface}) {
    for (const bool is_parallel : {true, false}) {
      Look look = semi_transparent_look(0, 1);
      look.mode = mode;
      look.isovalue = 0.62;
      TestScene scene{field, askew_camera(field, is_parallel, 1.3), look, direct_options(50, 70)};
      ImageTolerance tolerance;
      if (mode == Mode::kXray)
        tolerance.peak = greatest_color(draw(scene, Backend::kReference).image);
      EXPECT_TRUE(backends_agree(
          scene, "mode " + std::to_string(static_cast<int>(mode)) + view_text(is_parallel), 0.05,
          tolerance));
      if (mode == Mode::kIsosurface) continue;
      // A thick slice, which sheets do not end at.
      const auto planes = slice_planes({{0.4, -0.5, 0.7}, 0.31}, 0.13);
      scene.options.clip_planes.assign(planes.begin(), planes.end());
      if (mode == Mode::kXray)
        tolerance.peak = greatest_color(draw(scene, Backend::kReference).image);
      EXPECT_TRUE(backends_agree(
          scene,
          "thick slice, mode " + std::to_string(static_cast<int>(mode)) + view_text(is_parallel),
          0.05, tolerance));
    }
  }
}

// The vulkan back end leaves several surfaces to the cpu.
TEST(KernelSets, TellThreeIsosurfacesApart) {
  OVOID_NIGHTLY_ON_DEVICE();
  if (tested_backend() == Backend::kVulkan) GTEST_SKIP() << "drawn by the cpu";
  const KernelField field(jittered_ellipsoids(8).source(), Reconstruction::kNormalized, 0, 1);
  for (const bool is_parallel : {true, false}) {
    Look look = semi_transparent_look(0, 1);
    look.mode = Mode::kIsosurface;
    look.isosurfaces = {{0.62, {}, 0.5}, {0.7, Rgb{0.1, 0.2, 0.9}, 1.0}, {0.5, {}, 0.3}};
    const TestScene scene{field, askew_camera(field, is_parallel, 1.3), look,
                          direct_options(50, 70)};
    EXPECT_TRUE(backends_agree(scene, "three surfaces" + view_text(is_parallel)));
  }
}

// Fails if sets read the coarse volume of light otherwise than lattices do.
TEST(KernelSets, AgreeOnLightFromACoarseVolume) {
  OVOID_NIGHTLY_ON_DEVICE();
  const KernelField field(jittered_ellipsoids(8).source(), Reconstruction::kNormalized);
  for (const Mode mode : {Mode::kComposite, Mode::kIsosurface}) {
    for (const bool is_parallel : {true, false}) {
      Look look = semi_transparent_look(0, 1);
      look.mode = mode;
      look.isovalue = 0.62;
      look.occlusion = 1;
      look.shadows = 0.8;
      look.scatter = 0.5;
      look.material.specular = 0;  // which jumps where a normal passes the picture's plane
      TestScene scene{field, askew_camera(field, is_parallel, 1.3), look, direct_options(50, 70)};
      const std::string view =
          "mode " + std::to_string(static_cast<int>(mode)) + view_text(is_parallel);
      EXPECT_TRUE(backends_agree(scene, view + ", headlight with occlusion", 0.05));
      scene.look.light_direction = Vec3(3, 1, -2);
      EXPECT_TRUE(backends_agree(scene, view + ", directional light with shadows", 0.05));
    }
  }
}

TEST(KernelSets, AgreeOnSumsMeansAndProfiles) {
  for (const KernelProfile profile : {KernelProfile::kGaussian, KernelProfile::kCubicSpline,
                                      KernelProfile::kWendlandC2, KernelProfile::kEpanechnikov}) {
    KernelNumbers numbers = jittered_balls(7);
    numbers.profile = profile;
    for (const Reconstruction sum : {Reconstruction::kSum, Reconstruction::kNormalized}) {
      for (const Slab slab : {Slab::kMid, Slab::kMean}) {
        const KernelField field(numbers.source(), sum);
        TestScene scene{field, askew_camera(field, false, 1.2), semi_transparent_look(0, 1),
                        direct_options(40, 40)};
        scene.options.slab = slab;
        ImageTolerance tolerance;
        if (profile == KernelProfile::kEpanechnikov && slab == Slab::kMean)
          tolerance = {kKinkedMeanPsnrDb, kKinkedMean8BitDifference};
        EXPECT_TRUE(backends_agree(scene,
                                   std::string(name_of(profile)) +
                                       (slab == Slab::kMean ? ", mean" : ", mid") +
                                       (sum == Reconstruction::kSum ? ", sum" : ""),
                                   0.05, tolerance));
      }
    }
  }
}

// Ellipsoids in means lean against the rays.
TEST(KernelSets, AgreeOnMeansOfEllipsoids) {
  const KernelField field(jittered_ellipsoids(7, 3).source(), Reconstruction::kNormalized);
  for (const bool is_parallel : {true, false}) {
    TestScene scene{field, askew_camera(field, is_parallel, 1.5), semi_transparent_look(0, 1),
                    direct_options(40, 44)};
    scene.options.slab = Slab::kMean;
    EXPECT_TRUE(backends_agree(scene, "means" + view_text(is_parallel)));
  }
}

TEST(KernelSets, AgreeOnOtherOptions) {
  OVOID_NIGHTLY_ON_DEVICE();
  const KernelField field(jittered_ellipsoids(7).source(), Reconstruction::kNormalized);
  for (const bool is_parallel : {true, false}) {
    const TestScene plain{field, askew_camera(field, is_parallel, 1.3), semi_transparent_look(0, 1),
                          direct_options(70, 40)};
    TestScene scene = plain;
    scene.options.classification = Classification::kPreintegrated;
    EXPECT_TRUE(backends_agree(scene, "pre-integrated" + view_text(is_parallel)));
    const std::vector<ClipPlane> clip_planes = {{{-1, 0.6, 0.5}, -0.1}, {{0.2, 1, 0}, 0.3}};
    scene.options.clip_planes = clip_planes;
    EXPECT_TRUE(backends_agree(scene, "pre-integrated, clipped" + view_text(is_parallel), 0.02));
    const Vec3 ahead = scene.camera.focal_point - scene.camera.position;
    scene.options.clip_planes = {{ahead, ahead.dot(scene.camera.focal_point + 0.013 * ahead)}};
    scene.look.transfer_function.opacities = {{0.45, 0}, {0.5, 1}, {0.55, 0}};
    EXPECT_TRUE(backends_agree(scene, "pre-integrated, cut open" + view_text(is_parallel), 0.02));
    scene = plain;
    scene.options.clip_planes = clip_planes;
    EXPECT_TRUE(backends_agree(scene, "clipped" + view_text(is_parallel), 0.02));
    scene.look.mode = Mode::kIsosurface;
    scene.look.isovalue = 0.5;
    EXPECT_TRUE(backends_agree(scene, "clipped surface" + view_text(is_parallel), 0.02));
    scene = plain;
    scene.look.transfer_function.gradient_opacities = {{0.3, 0}, {2.0, 1}};
    EXPECT_TRUE(backends_agree(scene, "gradient opacity" + view_text(is_parallel)));
    scene = plain;
    scene.options.evaluate = Evaluate::kGather;
    EXPECT_TRUE(backends_agree(scene, "fragment-centric" + view_text(is_parallel)));
    scene.options.slab = Slab::kMean;
    EXPECT_TRUE(backends_agree(scene, "fragment-centric means" + view_text(is_parallel)));
  }
}

// Fails if sets without light are dimmed otherwise than lattices.
TEST(KernelSets, AgreeOnUnlitLooksThatAreDimmed) {
  OVOID_NIGHTLY_ON_DEVICE();
  const KernelField field(jittered_ellipsoids(8).source(), Reconstruction::kNormalized);
  for (const Mode mode : {Mode::kComposite, Mode::kIsosurface}) {
    Look look = semi_transparent_look(0, 1);
    look.mode = mode;
    look.isovalue = 0.62;
    look.shade = false;
    look.occlusion = 0.9;
    look.shadows = 0.6;
    look.light_direction = Vec3(3, 1, -2);
    const TestScene scene{field, askew_camera(field, false, 1.3), look, direct_options(50, 70)};
    EXPECT_TRUE(
        backends_agree(scene, "unlit, mode " + std::to_string(static_cast<int>(mode)), 0.05));
  }
}

// Fails if further lights are lost on sets.
TEST(KernelSets, AgreeOnFurtherLights) {
  OVOID_NIGHTLY_ON_DEVICE();
  const KernelField field(jittered_ellipsoids(8).source(), Reconstruction::kNormalized);
  for (const Mode mode : {Mode::kComposite, Mode::kIsosurface}) {
    Look look = semi_transparent_look(0, 1);
    look.mode = mode;
    look.isovalue = 0.62;
    look.material = {0.1, 0.4, 0, 1};  // highlights jump where a normal passes the picture's plane
    look.further_lights = {{Vec3(3, 1, -2), 0.7}, {Vec3(-1, 2, 0.5), 0.4}};
    const TestScene scene{field, askew_camera(field, false, 1.3), look, direct_options(50, 70)};
    EXPECT_TRUE(backends_agree(
        scene, "further lights, mode " + std::to_string(static_cast<int>(mode)), 0.05));
  }
}

// Fails if light of sets does not fade towards cuts as that of lattices does.
TEST(KernelSets, AgreeOnCutFaces) {
  OVOID_NIGHTLY_ON_DEVICE();
  const KernelField field(jittered_ellipsoids(7).source(), Reconstruction::kNormalized);
  for (const bool is_parallel : {true, false}) {
    TestScene scene{field, askew_camera(field, is_parallel, 1.3), semi_transparent_look(0, 1),
                    direct_options(60, 50)};
    const Vec3 axis = (scene.camera.focal_point - scene.camera.position).normalized();
    const Vec3 center = field.world_bounds().center();
    for (const Vec3& lean : {Vec3(0.4, 0.1, -0.2), Vec3(-0.5, 0.5, 0.3)}) {
      const Vec3 normal = axis + lean;
      scene.options.clip_planes.push_back({normal, normal.dot(center) - 0.05});
      for (const Classification classification :
           {Classification::kSampled, Classification::kRefined}) {
        scene.options.classification = classification;
        EXPECT_TRUE(backends_agree(scene,
                                   "cut faces, classification " +
                                       std::to_string(static_cast<int>(classification)) +
                                       view_text(is_parallel),
                                   0.02));
      }
    }
  }
}

// Fails if colour is taken at the other attribute's value, or of the wrong function.
TEST(KernelSets, ColorMayComeFromAnotherAttribute) {
  for (const Reconstruction sum : {Reconstruction::kNormalized, Reconstruction::kSum}) {
    const KernelField field(jittered_ellipsoids(7).source(), sum, 0, 1);
    Look look = semi_transparent_look(0, 1);
    look.color_function = ramp_look(field.color_range()).transfer_function;
    for (const Mode mode : {Mode::kComposite, Mode::kIsosurface}) {
      look.mode = mode;
      look.isovalue = 0.5;
      const TestScene scene{field, askew_camera(field, false), look, direct_options(50, 50)};
      EXPECT_TRUE(backends_agree(scene, "own colour"));
      TestScene same = scene;
      same.field = KernelField(field.shared_source(), sum, 0);
      EXPECT_LT(compare(draw(same).image, draw(scene).image).psnr_db, 40);
    }
  }
}

// From kernels below a pixel to a tenth of the picture: none may be lost or counted twice.
TEST(KernelSets, AgreeOnAllSizesAtOnce) {
  OVOID_NIGHTLY_ON_DEVICE();
  const KernelField field(balls_of_all_sizes(4000, 1e-4).source(), Reconstruction::kSum);
  for (const Slab slab : {Slab::kMid, Slab::kMean}) {
    Look look = semi_transparent_look(0, field.value_range().hi);
    TestScene scene{field, askew_camera(field, false, 1.2), look, direct_options(60, 60, 0.01)};
    scene.options.slab = slab;
    EXPECT_TRUE(backends_agree(scene, "all sizes"));
  }
}

// The camera inside the set: kernels that cross the near plane are cut, not dropped.
TEST(KernelSets, AgreeFromWithin) {
  OVOID_NIGHTLY_ON_DEVICE();
  const KernelField field(jittered_ellipsoids(6).source(), Reconstruction::kNormalized);
  Camera camera;
  camera.position = Vec3(0.5, 0.45, 0.6);
  camera.focal_point = Vec3(0.1, 0.3, 0.2);
  camera.view_angle = 80;
  TestScene scene{field, camera, semi_transparent_look(0, 1), direct_options(70, 50)};
  EXPECT_TRUE(backends_agree(scene, "from within", 0.5));
  scene.look.transfer_function.opacities = {{0.45, 0}, {0.5, 1}, {0.55, 0}};
  scene.options.classification = Classification::kPreintegrated;
  EXPECT_TRUE(backends_agree(scene, "pre-integrated, from within", 0.5));
}

// Skipping and stopping change time, not pixels.
TEST(KernelSets, SkippingChangesNoByte) {
  OVOID_NIGHTLY_ON_DEVICE();
  const KernelField field(jittered_ellipsoids(9).source(), Reconstruction::kNormalized);
  const std::vector<ClipPlane> planes[] = {{}, {{{-1, 0.6, 0.5}, -0.1}, {{0, 0, 1}, 0.55}}};
  for (const TestLook& look : test_looks(0, 1)) {
    for (const PostConvolution levels : {PostConvolution::kOff, PostConvolution::kAuto}) {
      for (const std::vector<ClipPlane>& clip_planes : planes) {
        TestScene scene{field, askew_camera(field, false, 1.5), look.look,
                        direct_options(130, 100)};
        scene.options.post_convolution = levels;
        scene.options.clip_planes = clip_planes;
        const Image skipped = draw(scene).image;
        scene.options.skip_irrelevant = false;
        scene.options.stop_opaque = false;
        EXPECT_EQ(draw(scene).image.rgba, skipped.rgba) << look.name;
      }
    }
  }
}

// A dense clump in a wide cloud of faint balls, some of negative value.
KernelNumbers clump_in_a_cloud() {
  KernelNumbers set = balls_of_all_sizes(3000, 0.02);
  for (std::size_t i = 0; i < set.weights.size(); ++i) {
    const bool is_in_clump = i % 3 == 0;
    for (std::size_t a = 0; a < 3; ++a) {
      double& x = set.centers[3 * i + a];
      x = is_in_clump ? 0.5 + 0.1 * (x - 0.5) : 8 * x - 3.5;
    }
    set.shapes[i] = is_in_clump ? 0.01F : 0.2F;
    set.weights[i] = is_in_clump ? 1.0F : 0.02F;
    set.values[0][i] = i % 7 == 0 ? -0.5F : 1.0F;
  }
  return set;
}

// The same of a sum, whose bounds come from the splats: blocks of the faint cloud cannot show.
TEST(KernelSets, SkippingFaintSumsChangesNoByte) {
  OVOID_NIGHTLY_ON_DEVICE();
  const KernelField field(clump_in_a_cloud().source(), Reconstruction::kSum);
  const double hi = field.value_range().hi;
  std::vector<TestLook> looks = test_looks(static_cast<float>(0.2 * hi), static_cast<float>(hi));
  looks.push_back({"surface", with_mode(looks[0].look, Mode::kIsosurface)});
  looks.back().look.isovalue = 0.3 * hi;
  int num_skipping = 0;
  for (const TestLook& look : looks) {
    for (const PostConvolution levels : {PostConvolution::kOff, PostConvolution::kAuto}) {
      for (const bool is_parallel : {true, false}) {
        TestScene scene{field, askew_camera(field, is_parallel), look.look, picture(200, 190)};
        scene.options.post_convolution = levels;
        const Frame skipped = draw(scene);
        scene.options.skip_irrelevant = false;
        const Frame whole = draw(scene);
        EXPECT_EQ(skipped.image.rgba, whole.image.rgba) << look.name;
        if (skipped.profile.blocks_drawn < whole.profile.blocks_drawn / 2) ++num_skipping;
      }
    }
  }
  if (tested_backend() == Backend::kCpu) {  // which counts blocks
    EXPECT_GT(num_skipping, 8) << "hardly anything was skipped";
  }
}

// Clears pixels that show something in one picture alone; returns how many.
int clear_seen_by_one(Image& a, Image& b) {
  int count = 0;
  for (std::size_t p = 0; p < a.rgba.size(); p += 4) {
    if ((a.rgba[p + 3] > 0) == (b.rgba[p + 3] > 0)) continue;
    std::fill_n(a.rgba.begin() + static_cast<std::ptrdiff_t>(p), 4, 0.0F);
    std::fill_n(b.rgba.begin() + static_cast<std::ptrdiff_t>(p), 4, 0.0F);
    ++count;
  }
  return count;
}

// Balls of a sum that are far smaller than pixels and sheets share splats, and the picture shows it
// to the tier of levels.
TEST(KernelSets, BallsSmallerThanSamplesMerge) {
  OVOID_NIGHTLY_ON_DEVICE();
  if (is_on_device() && !is_on_graphics_processor())
    GTEST_SKIP() << "software drivers refuse so many kernels in one tile";
  KernelNumbers set = balls_of_all_sizes(120000, 0.001);
  for (std::size_t i = 0; i < set.weights.size(); ++i) {  // Plummer's sphere
    const Vec3 out(set.centers[3 * i] - 0.5, set.centers[3 * i + 1] - 0.5,
                   set.centers[3 * i + 2] - 0.5);
    const double share = (static_cast<double>(i) + 0.5) / static_cast<double>(set.weights.size());
    const double radius = std::min(0.1 / std::sqrt(std::pow(share, -2.0 / 3) - 1), 0.7);
    for (std::size_t a = 0; a < 3; ++a)
      set.centers[3 * i + a] = 0.5 + out[static_cast<int>(a)] * radius / out.norm();
    set.shapes[i] = 0.001F + 0.0003F * static_cast<float>(i % 5);
  }
  const KernelField field(set.source(), Reconstruction::kSum);
  const ValueRange range = field.value_range();
  std::vector<TestLook> looks = test_looks(0, 0.002F * range.hi);
  looks.push_back({"surface", with_mode(looks[0].look, Mode::kIsosurface)});
  looks.back().look.isovalue = 0.0005 * range.hi;
  for (const TestLook& look : looks) {
    for (const bool is_parallel : {true, false}) {
      TestScene scene{field, askew_camera(field, is_parallel), look.look, picture(90, 90, 0.02)};
      Frame merged = draw(scene);
      scene.options.post_convolution = PostConvolution::kOff;
      Frame direct = draw(scene);
      if (tested_backend() == Backend::kCpu) {  // the others share no splats
        EXPECT_LT(merged.profile.kernels_loaded, 0.7 * direct.profile.kernels_loaded) << look.name;
      }
      EXPECT_LE(clear_seen_by_one(merged.image, direct.image), 3);
      const ImageDifference difference = compare(merged.image, direct.image);
      EXPECT_GT(difference.num_covered, 300);
      EXPECT_GE(difference.psnr_db, kLevelsPsnrDb)
          << look.name << view_text(is_parallel) << ": " << difference.to_string();
    }
  }
}

// Magnified until kernels go to the coarse levels: the tier of post-convolution. Fails if a level's
// samples lie elsewhere, or the filter's phases are swapped.
TEST(KernelSets, LevelsAgreeWithDirectSums) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NIGHTLY_ON_DEVICE();
  if (is_on_graphics_processor()) GTEST_SKIP() << "which sums all kernels directly";
  for (const NamedKernelSet& set : kernel_test_sets()) {
    const KernelField field(set.numbers.source(), Reconstruction::kNormalized);
    std::vector<TestLook> looks = test_looks(0, 1);
    looks.push_back({"surface", with_mode(looks[3].look, Mode::kIsosurface)});
    looks.back().look.isovalue = 0.51;
    for (const TestLook& look : looks) {
      TestScene scene{field, askew_camera(field, false, 6), look.look, picture(150, 140)};
      const Image direct =
          draw({scene.field, scene.camera, scene.look, direct_options(150, 140)}).image;
      const ImageDifference difference = compare(draw(scene).image, direct);
      EXPECT_GE(difference.psnr_db, kLevelsPsnrDb)
          << set.name << ", " << look.name << ": " << difference.to_string();
      EXPECT_LT(difference.psnr_db, 130) << "no kernel went to a level";
      EXPECT_GT(difference.num_covered, 300);
    }
  }
}

std::int64_t num_seen(const Image& image) {
  std::int64_t count = 0;
  for (std::size_t p = 3; p < image.rgba.size(); p += 4) count += image.rgba[p] > 0 ? 1 : 0;
  return count;
}

// Fails if what filters carry beyond the cut of a kernel counts as a part of a sum: pictures of
// sums would end at samples of coarse levels.
TEST(KernelSets, SumsOnLevelsEndWhereTheirKernelsDo) {
  OVOID_NIGHTLY_ON_DEVICE();
  if (is_on_graphics_processor()) GTEST_SKIP() << "which sums all kernels directly";
  KernelNumbers blobs = balls_of_all_sizes(300, 0.02);
  for (const NamedKernelSet& set : {NamedKernelSet{"ellipsoids", jittered_ellipsoids(5)},
                                    NamedKernelSet{"balls of all sizes", blobs}}) {
    const KernelField field(set.numbers.source(), Reconstruction::kSum);
    for (const Mode mode : {Mode::kXray, Mode::kMean, Mode::kMaximum, Mode::kComposite}) {
      for (const bool is_parallel : {true, false}) {
        Look look = semi_transparent_look(-field.value_range().hi, field.value_range().hi);
        look.mode = mode;
        look.shade = false;  // of next to nothing: what is seen at the kernels' ends
        TestScene scene{field, askew_camera(field, is_parallel, 0.6), look, picture(190, 180)};
        TestScene direct = scene;
        direct.options.post_convolution = PostConvolution::kOff;
        Image expected = draw(direct).image;
        Image image = draw(scene).image;
        // Where a kernel ends it is nothing within the rounding.
        EXPECT_LE(clear_seen_by_one(image, expected), 3);
        const double peak = mode == Mode::kXray ? greatest_color(expected) : 1.0;
        const ImageDifference difference = compare(image, expected, peak);
        const std::string name = set.name + ", mode " + std::to_string(static_cast<int>(mode)) +
                                 view_text(is_parallel) + ": " + difference.to_string();
        EXPECT_LT(num_seen(expected), 190 * 180) << name << ": nothing ends in the picture";
        EXPECT_GT(num_seen(expected), 3000) << name;
        EXPECT_GE(difference.psnr_db, kLevelsPsnrDb) << name;
        EXPECT_LT(difference.psnr_db, 130) << name << ": no kernel went to a level";
      }
    }
  }
}

// At cut-off 6, where a box and a ball agree, a lattice and its own kernels give one picture.
TEST(KernelSets, EqualTheLatticeOfTheSameKernels) {
  OVOID_NIGHTLY_ON_DEVICE();
  constexpr int kEdge = 9;
  const KernelNumbers numbers = lattice_balls(kEdge, 6);
  const KernelField set(numbers.source(), Reconstruction::kNormalized);
  const VolumeFunction values = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return static_cast<double>(
        numbers.values[0][static_cast<std::size_t>(i + kEdge * (j + kEdge * k))]);
  };
  FieldSetup setup;
  setup.kernel = {.sigma = 0.5, .cutoff = 6};
  const LatticeField lattice =
      make_stored_field({kEdge, kEdge, kEdge}, values, {ScalarType::kFloat32, 0, 1}, setup);
  for (const bool is_parallel : {true, false}) {
    TestScene scene{set, askew_camera(lattice, is_parallel), semi_transparent_look(0, 1),
                    direct_options(60, 60, 1.0)};
    scene.options.slab = Slab::kMid;
    // Away from the borders, where the two end at different shares of the weights.
    for (int a = 0; a < 3; ++a) {
      scene.options.clip_planes.push_back({Vec3::Unit(a), 2.0});
      scene.options.clip_planes.push_back({-Vec3::Unit(a), -6.0});
    }
    TestScene same = scene;
    same.field = lattice;
    same.options.gradient = GradientMethod::kCentral;
    for (const Backend backend : {Backend::kReference, Backend::kCpu}) {
      const ImageDifference difference =
          compare(draw(scene, backend).image, draw(same, backend).image);
      EXPECT_GT(difference.num_covered, 300);
      EXPECT_LT(difference.max_float, backend == Backend::kReference ? 1e-5 : 1e-4)
          << difference.to_string();
    }
  }
}

}  // namespace kernel_sets_test
}  // namespace ovoid::test
