// SPDX-License-Identifier: Apache-2.0
// The cpu back end against the reference, one feature after the other.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstring>

#include "data/lattice/resident_lattice.h"
#include "ovoid/crop.h"
#include "ovoid/model.h"
#include "support/agreement.h"
#include "support/scenes.h"
#include "support/where.h"

namespace ovoid::test {
namespace features_test {

std::string projection_name(bool is_parallel) { return is_parallel ? "parallel" : "perspective"; }

// The scene's field with another kernel or reconstruction.
void set_kernel(TestScene& scene, const LatticeKernel& kernel, Reconstruction reconstruction) {
  const Index3 dims = scene.lattice().geometry().dims;
  FieldSetup setup;
  setup.world_from_index = scene.lattice().geometry().world_from_index;
  setup.kernel = kernel;
  setup.reconstruction = reconstruction;
  scene.field = make_stored_field(dims, shells(dims), {ScalarType::kFloat32, 10, 50}, setup);
}

// Kernels that reach as far as the published one, which they stand beside.
constexpr LatticeKernel kOneSize[] = {{}, kBSplineKernel, kCatmullRomKernel};

// The same samples under another kernel of one size.
LatticeField with_kernel(const LatticeField& field, const LatticeKernel& kernel) {
  const auto kept = std::make_shared<const LatticeField>(field);
  return {std::shared_ptr<const BrickSource>(kept, &kept->source()), kernel,
          field.reconstruction()};
}

class EveryMode : public ::testing::TestWithParam<int> {
 protected:
  Mode mode() const { return kModes[GetParam()]; }
  std::string name() const { return kModeNames[GetParam()]; }
};

// Fails if a mode, a slab's mean, a sum or a way to evaluate takes a number otherwise than
// docs/numerics.md says.
TEST_P(EveryMode, SlabsReconstructionsEvaluations) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const bool is_parallel : {true, false}) {
    for (const Reconstruction reconstruction :
         {Reconstruction::kNormalized, Reconstruction::kSum}) {
      // The least of a sum is next to nothing on many sheets: rounding decides on which.
      if (mode() == Mode::kMinimum && reconstruction == Reconstruction::kSum) continue;
      for (const Slab slab : {Slab::kMid, Slab::kMean}) {
        for (const LatticeKernel& kernel : kOneSize) {
          TestScene scene = small_scene(mode(), is_parallel);
          set_kernel(scene, kernel, reconstruction);
          scene.options.slab = slab;
          expect_agreement_however_evaluated(
              scene, name() + ", " + projection_name(is_parallel) + ", " + name_of(kernel.kind) +
                         (reconstruction == Reconstruction::kSum ? ", sum" : "") +
                         (slab == Slab::kMean ? ", slab means" : ""));
        }
      }
    }
  }
}

// Fails if central differences do not reach over the edges of blocks, tiles and the picture, or
// stop at the field's own.
TEST_P(EveryMode, CentralDifferences) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const bool is_parallel : {true, false}) {
    TestScene scene = small_scene(mode(), is_parallel);
    scene.options.gradient = GradientMethod::kCentral;
    expect_agreement_however_evaluated(scene,
                                       name() + ", " + projection_name(is_parallel) + ", central");
  }
}

// Fails if the correction of ramps is not left out where the derivative as it is was asked for.
TEST_P(EveryMode, ExactGradients) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const Slab slab : {Slab::kMid, Slab::kMean}) {
    TestScene scene = small_scene(mode(), slab == Slab::kMid);
    scene.options.slab = slab;
    scene.options.gradient = GradientMethod::kExact;
    expect_agreement_however_evaluated(
        scene, name() + (slab == Slab::kMean ? ", slab means" : "") + ", exact gradients");
  }
}

// Fails if planes do not shorten paths, cut samples away or pass over crossings as they should.
TEST_P(EveryMode, ClipPlanes) {
  OVOID_NIGHTLY_ON_DEVICE();
  const Vec3 center = small_scene(mode(), true).field.world_bounds().center();
  const ClipPlane straight{{0, 0, 2}, 2 * center.z() + 0.3};
  const Vec3 slanted(-1.0, 0.6, 0.5);
  const ClipPlane oblique{slanted, slanted.dot(center) - 1.7};
  for (const bool is_parallel : {true, false}) {
    TestScene scene = small_scene(mode(), is_parallel);
    const std::string view = name() + ", " + projection_name(is_parallel);
    scene.options.clip_planes = {straight};
    EXPECT_TRUE(backends_agree(scene, view + ", one plane"));
    scene.options.clip_planes = {oblique};
    EXPECT_TRUE(backends_agree(scene, view + ", oblique plane"));
    scene.options.clip_planes = {straight, oblique};
    EXPECT_TRUE(backends_agree(scene, view + ", two planes", 0.02));
    scene.options.clip_planes = {{straight}, {-straight.normal, -straight.offset + 1}};
    EXPECT_TRUE(backends_agree(scene, view + ", planes that leave nothing", 0));
    const Image nothing = draw(scene).image;
    for (const float component : nothing.rgba) ASSERT_EQ(component, 0.0F);
  }
}

// Slices thinner and thicker than a sheet, between sheets anyhow; holes and faces within. Fails if
// a back end shows the samples on sheets instead of what lies between the planes.
TEST(Agreement, ModesThatShowValuesOfThickSlices) {
  OVOID_NIGHTLY_ON_DEVICE();
  const Vec3 normal(0.4, -0.5, 0.7);
  for (const Mode mode : {Mode::kXray, Mode::kMaximum, Mode::kMinimum, Mode::kMean}) {
    for (const bool is_parallel : {true, false}) {
      TestScene scene = small_scene(mode, is_parallel);
      const double offset = normal.dot(scene.field.world_bounds().center());
      const double sheet = scene.field.default_sampling_distance();
      for (const double thickness : {0.3, 4.7}) {
        if (is_left_out(static_cast<int>(mode), thickness < 1 ? 0 : 1)) continue;
        const auto planes = slice_planes({normal, offset + 0.17 * sheet}, thickness * sheet);
        scene.options.clip_planes.assign(planes.begin(), planes.end());
        expect_agreement_however_evaluated(
            scene, fmt::format("{}, {}, {} sheets thick", kModeNames[static_cast<int>(mode)],
                               projection_name(is_parallel), thickness));
      }
    }
  }
}

// Surfaces that are seen through, one in a colour of its own. The vulkan back end leaves several to
// the cpu.
TEST(Agreement, ThreeIsosurfaces) {
  OVOID_NIGHTLY_ON_DEVICE();
  if (tested_backend() == Backend::kVulkan) GTEST_SKIP() << "drawn by the cpu";
  for (const bool is_parallel : {true, false}) {
    TestScene scene = small_scene(Mode::kIsosurface, is_parallel);
    const double middle = scene.look.isovalue;
    scene.look.isosurfaces = {
        {middle, {}, 0.4}, {1.3 * middle, Rgb{0.9, 0.2, 0.1}, 0.5}, {0.7 * middle, {}, 1.0}};
    expect_agreement_however_evaluated(scene, "three surfaces, " + projection_name(is_parallel));
    const Vec3 slanted(-1.0, 0.6, 0.5);
    scene.options.clip_planes = {{slanted, slanted.dot(scene.field.world_bounds().center()) - 0.7}};
    EXPECT_TRUE(backends_agree(scene, "cut, " + projection_name(is_parallel)));
  }
}

// Fails if light does not fade towards cuts that are seen, and to those alone, as it should: with
// one of them, two that meet in an edge, one that is not seen.
TEST(Agreement, CutFaces) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const bool is_parallel : {true, false}) {
    TestScene scene = small_scene(Mode::kComposite, is_parallel);
    scene.options = picture(56, 44);
    scene.look.material = {0.1, 0.8, 0.4, 8};
    const Vec3 center = scene.field.world_bounds().center();
    const Vec3 axis = (scene.camera.focal_point - scene.camera.position).normalized();
    const Vec3 side = axis.cross(Vec3(0.3, 1, 0.2)).normalized();
    const auto plane = [&](const Vec3& normal, double beyond) {
      return ClipPlane{1.7 * normal, 1.7 * (normal.dot(center) + beyond)};
    };
    const std::vector<ClipPlane> all = {plane(axis + 0.6 * side, -0.5), plane(axis - side, -1.3),
                                        plane(-axis, -2.5)};
    for (const int count : {1, 2, 3}) {
      scene.options.clip_planes.assign(all.begin(), all.begin() + count);
      for (const Classification classification :
           {Classification::kSampled, Classification::kPreintegrated, Classification::kRefined}) {
        scene.options.classification = classification;
        const std::string what =
            fmt::format("{} cuts, classification {}, {}", count, static_cast<int>(classification),
                        projection_name(is_parallel));
        scene.look.occlusion = scene.look.shadows = 0;
        EXPECT_TRUE(backends_agree(scene, what, 0.02));
        scene.look.occlusion = scene.look.shadows = 0.7;
        EXPECT_TRUE(backends_agree(scene, what + ", light from a volume", 0.02));
        if (classification == Classification::kSampled && tested_backend() != Backend::kVulkan) {
          TestScene on_lattice = scene;
          on_lattice.options.sheets = Sheets::kLattice;
          EXPECT_TRUE(backends_agree(on_lattice, what + ", lattice sheets", 0.02));
        }
      }
    }
  }
}

// Fails if sheets at and before the near plane are drawn, or those just behind it are not.
TEST_P(EveryMode, CameraInsideTheVolume) {
  OVOID_NIGHTLY_ON_DEVICE();
  TestScene scene = small_scene(mode(), false);
  scene.camera.position = scene.field.world_bounds().center();
  scene.camera.focal_point = scene.camera.position + Vec3(1.1, 3.2, 4.0);
  scene.camera.view_angle = 70;
  expect_agreement_however_evaluated(scene, name() + ", camera inside");
}

// Fails if kernels narrower than a pixel are not widened, sheet by sheet in perspective.
TEST_P(EveryMode, Minification) {
  OVOID_NIGHTLY_ON_DEVICE();
  const auto check = [&](bool is_parallel, double pitch, Reconstruction reconstruction,
                         const LatticeKernel& kernel) {
    TestScene scene = small_scene(mode(), is_parallel);
    set_kernel(scene, kernel, reconstruction);
    scene.options = picture(20, 18, 1.5);
    const double half_height = 0.5 * 18 * pitch * scene.field.default_sampling_distance();
    const Vec3 center = scene.field.world_bounds().center();
    const Vec3 direction(0.48, -0.31, 0.82);
    scene.camera = is_parallel
                       ? parallel_camera(center, direction, half_height, 60)
                       : perspective_camera(center, direction, half_height, 4 * half_height);
    const std::string name_here = name() + ", " + projection_name(is_parallel) + ", " +
                                  name_of(kernel.kind) +
                                  (reconstruction == Reconstruction::kSum ? ", sum" : "") +
                                  ", pitch " + (pitch == 2.0 ? "2" : "5");
    // Sums fade towards the faces, out of the range that shows.
    EXPECT_TRUE(
        backends_agree(scene, name_here, reconstruction == Reconstruction::kSum ? 0.0 : 0.02));
  };
  for (const bool is_parallel : {true, false}) {
    for (const double pitch : {2.0, 5.0}) {
      for (const LatticeKernel& kernel : kOneSize) {
        check(is_parallel, pitch, Reconstruction::kNormalized, kernel);
        check(is_parallel, pitch, Reconstruction::kSum, kernel);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Modes, EveryMode, ::testing::Range(0, 6),
                         [](const auto& test) { return kModeNames[test.param]; });

// Fails if the far from default paths (other tap counts, wide supports) differ from the definition.
TEST(Agreement, KernelShapes) {
  OVOID_NIGHTLY_ON_DEVICE();
  constexpr LatticeKernel kKernels[] = {{0.3, 5}, {0.7, 4}, {0.5, 3}, {1.0, 3}};
  for (const LatticeKernel& kernel : kKernels) {
    for (const Reconstruction reconstruction :
         {Reconstruction::kNormalized, Reconstruction::kSum}) {
      for (const bool is_parallel : {true, false}) {
        TestScene scene = small_scene(Mode::kComposite, is_parallel);
        set_kernel(scene, kernel, reconstruction);
        const std::string name = "sigma " + std::to_string(kernel.sigma).substr(0, 3) + " cutoff " +
                                 std::to_string(kernel.cutoff).substr(0, 1) + ", " +
                                 projection_name(is_parallel) +
                                 (reconstruction == Reconstruction::kSum ? ", sum" : "");
        expect_agreement_however_evaluated(scene, name);
      }
    }
  }
}

// Fails if missing samples are summed as zeros, or their places' weights as present.
TEST(Agreement, HolesInEveryMode) {
  OVOID_NIGHTLY_ON_DEVICE();
  const TestVolume volume = test_volumes()[2];
  for (const LatticeKernel& kernel : kOneSize) {
    const LatticeField field = with_kernel(volume.field, kernel);
    for (int m = 0; m < 5; ++m) {
      TestScene scene{field, askew_camera(field, m % 2 == 0, 1.4),
                      semi_transparent_look(volume.lo, volume.hi), picture(40, 36)};
      scene.look.mode = kModes[m];
      scene.look.isovalue = 0.3;
      expect_agreement_however_evaluated(
          scene, std::string("holes, ") + name_of(kernel.kind) + ", " + kModeNames[m]);
    }
  }
}

// Fails if coefficients, which overshoot the samples, are taken for values anywhere.
TEST(Agreement, PrefilteredField) {
  OVOID_NIGHTLY_ON_DEVICE();
  const Index3 dims{14, 13, 12};
  const VolumeFunction shape = shells(dims);
  std::vector<float> samples;
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i) {
        samples.push_back(static_cast<float>(shape(i, j, k)));
      }
    }
  }
  Dataset dataset;
  dataset.lattice = {dims, scaled_axes(Vec3(1, 0.8, 1.3))};
  DataArray array;
  array.name = "shells";
  array.num_tuples = num_samples(dims);
  array.bytes = {nullptr, std::as_bytes(std::span<const float>(samples))};
  dataset.arrays.push_back(array);
  for (const LatticeKernel& kernel : kOneSize) {
    LatticeModelOptions model;
    model.kernel = kernel;
    model.prefilter = true;
    model.threads = 1;
    const LatticeField field = make_lattice_field(dataset, model);
    for (const TestLook& look : test_looks(0, 1)) {
      if (look.name == "colour step") continue;  // other tests' subject
      const TestScene scene{field, askew_camera(field, false, 1.4), look.look, picture(40, 36)};
      expect_agreement_however_evaluated(
          scene, std::string("prefiltered, ") + name_of(kernel.kind) + ", " + look.name, 0.02);
    }
  }
}

// Fails if opacities or paths do not follow the distance of sheets.
TEST(Agreement, SamplingDistances) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const bool is_parallel : {true, false}) {
    for (const double factor : {0.25, 0.5, 2.0, 4.0}) {
      TestScene scene = small_scene(Mode::kComposite, is_parallel);
      set_kernel(scene, kBSplineKernel, Reconstruction::kNormalized);
      scene.options.sampling_distance = factor * scene.field.default_sampling_distance();
      expect_agreement_however_evaluated(scene, projection_name(is_parallel) + ", sheets at " +
                                                    std::to_string(factor).substr(0, 4));
    }
  }
}

// Fails if samples are left out whose slab reaches the field though their own place does not.
TEST(Agreement, LongSlabs) {
  for (const bool is_parallel : {true, false}) {
    for (const Reconstruction reconstruction :
         {Reconstruction::kNormalized, Reconstruction::kSum}) {
      TestScene scene = small_scene(Mode::kXray, is_parallel);
      set_kernel(scene, {}, reconstruction);
      scene.options = picture(24, 20, 3.1, Slab::kMean);
      EXPECT_TRUE(backends_agree(
          scene, projection_name(is_parallel) +
                     (reconstruction == Reconstruction::kSum ? ", sum" : "") + ", long slabs"));
    }
  }
}

// Fails if blocks smaller than a sample's own cell lose their kernels.
TEST(Agreement, Magnification) {
  for (const bool is_parallel : {true, false}) {
    TestScene scene = small_scene(Mode::kComposite, is_parallel);
    scene.camera = askew_camera(scene.field, is_parallel, 25);
    scene.options.sampling_distance = 0.1;
    scene.options.post_convolution = PostConvolution::kOff;
    expect_agreement_however_evaluated(scene, projection_name(is_parallel) + ", magnified", 0.9);
  }
}

// Fails if the light's side, the half vector or the highlight is off.
TEST(Agreement, Light) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const bool is_parallel : {true, false}) {
    for (const Mode mode : {Mode::kComposite, Mode::kIsosurface}) {
      TestScene scene = small_scene(mode, is_parallel);
      scene.options = picture(48, 40);
      const std::string view =
          std::string(mode == Mode::kComposite ? "composite, " : "isosurface, ") +
          projection_name(is_parallel);
      scene.look.light_direction = Vec3(3, 1, -2);
      EXPECT_TRUE(backends_agree(scene, view + ", directional light"));
      scene.look.light = Light::kStudio;
      EXPECT_TRUE(backends_agree(scene, view + ", studio"));
      scene.look.light_direction.reset();
      scene.look.flat_rise = 0.2;
      EXPECT_TRUE(backends_agree(scene, view + ", studio with the camera, flat where it is faint"));
      scene.look.flat_rise = 1e-4;
      scene.look.light = Light::kSingle;
      scene.look.light_direction = Vec3(3, 1, -2);
      scene.look.material = {0.2, 0.4, 0.9, 60};
      EXPECT_TRUE(backends_agree(scene, view + ", highlight"));
      scene.look.light_direction.reset();
      EXPECT_TRUE(backends_agree(scene, view + ", headlight"));
      scene.look.shade = false;
      EXPECT_TRUE(backends_agree(scene, view + ", no light"));
    }
  }
}

// Fails if a further light is lost, or weakened by what it should not be.
TEST(Agreement, FurtherLights) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const bool is_parallel : {true, false}) {
    for (const Mode mode : {Mode::kComposite, Mode::kIsosurface}) {
      if (is_left_out(is_parallel ? 1 : 0, mode == Mode::kComposite ? 1 : 0)) continue;
      TestScene scene = small_scene(mode, is_parallel);
      scene.options = picture(48, 40);
      scene.look.material = {0.1, 0.4, 0.3, 7.5};
      const std::string view =
          std::string(mode == Mode::kComposite ? "composite, " : "isosurface, ") +
          projection_name(is_parallel);
      const Image without = draw(scene).image;
      scene.look.further_lights = {{Vec3(3, 1, -2), 0.7}, {Vec3(-1, 2, 0.5), 0.4}};
      EXPECT_TRUE(backends_agree(scene, view + ", headlight and two"));
      EXPECT_LT(compare(draw(scene).image, without).psnr_db, 40);
      scene.look.light = Light::kStudio;
      scene.look.further_lights.resize(Look::kMaxFurtherLights, {Vec3(-2, -1, -1), 0.2});
      scene.look.flat_rise = 0.2;
      EXPECT_TRUE(backends_agree(scene, view + ", studio and four, flat where it is faint"));
      scene.look.flat_rise = 1e-4;
      scene.look.occlusion = 1;
      scene.look.shadows = 0.7;
      EXPECT_TRUE(backends_agree(scene, view + ", studio and four, with occlusion and shadows"));
      scene.look.light = Light::kSingle;
      scene.look.light_direction = Vec3(1, -1, -1);
      scene.look.material.specular = 0;
      EXPECT_TRUE(backends_agree(scene, view + ", a direction and four, without highlights"));
      if (mode != Mode::kComposite) continue;
      scene.options.classification = Classification::kSampled;
      EXPECT_TRUE(backends_agree(scene, view + ", a direction and four, sampled"));
    }
  }
}

// Fails if what arrives does not dim the colours of a look that is not lit, or reads it by a
// normal.
TEST(Agreement, UnlitLooksAreDimmed) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const bool is_parallel : {true, false}) {
    for (const Mode mode : {Mode::kComposite, Mode::kIsosurface}) {
      TestScene scene = small_scene(mode, is_parallel);
      scene.options = picture(48, 40);
      scene.look.shade = false;
      const std::string view =
          std::string(mode == Mode::kComposite ? "composite, " : "isosurface, ") +
          projection_name(is_parallel);
      const Image without = draw(scene).image;
      scene.look.occlusion = 1;
      EXPECT_TRUE(backends_agree(scene, view + ", unlit with occlusion"));
      EXPECT_LT(compare(draw(scene).image, without).psnr_db, 55);
      scene.look.light_direction = Vec3(3, 1, -2);
      scene.look.shadows = 0.8;
      scene.look.scatter = 0.5;
      EXPECT_TRUE(backends_agree(scene, view + ", unlit with occlusion and shadows"));
      if (mode != Mode::kComposite) continue;
      for (const Classification classification :
           {Classification::kSampled, Classification::kPreintegrated}) {
        scene.options.classification = classification;
        EXPECT_TRUE(backends_agree(scene, fmt::format("{}, unlit, classification {}", view,
                                                      static_cast<int>(classification))));
      }
      scene.options.classification = Classification::kRefined;
      scene.look.transfer_function.gradient_opacities = {{0, 0.2}, {3, 1}};
      EXPECT_TRUE(backends_agree(scene, view + ", unlit, faded by the gradient"));
      scene.look.transfer_function.gradient_opacities.clear();
      if (tested_backend() == Backend::kVulkan) continue;  // has image sheets
      scene.options.sheets = Sheets::kLattice;
      EXPECT_TRUE(backends_agree(scene, view + ", unlit, lattice sheets"));
    }
  }
}

// Fails if a back end reads the coarse volume of light elsewhere, or lights other parts with it.
TEST(Agreement, LightFromACoarseVolume) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const bool is_parallel : {true, false}) {
    for (const Mode mode : {Mode::kComposite, Mode::kIsosurface}) {
      if (is_left_out(is_parallel ? 1 : 0, mode == Mode::kComposite ? 1 : 0)) continue;
      TestScene scene = small_scene(mode, is_parallel);
      scene.options = picture(48, 40);
      scene.look.occlusion = 1;
      const std::string view =
          std::string(mode == Mode::kComposite ? "composite, " : "isosurface, ") +
          projection_name(is_parallel);
      EXPECT_TRUE(backends_agree(scene, view + ", headlight with occlusion"));
      scene.look.shadows = 0.8;
      scene.look.scatter = 0.5;
      scene.look.light = Light::kStudio;
      EXPECT_TRUE(backends_agree(scene, view + ", studio with shadows"));
      scene.options.clip_planes = {{Vec3(1, 0.4, 0.2), 4.0}};
      EXPECT_TRUE(backends_agree(scene, view + ", studio with shadows, clipped", 0.01));
      scene.options.clip_planes.clear();
      scene.look.light = Light::kSingle;
      scene.look.light_direction = Vec3(3, 1, -2);
      EXPECT_TRUE(backends_agree(scene, view + ", directional light with shadows"));
      for (const Classification classification :
           {Classification::kSampled, Classification::kPreintegrated}) {
        if (mode != Mode::kComposite) break;
        scene.options.classification = classification;
        EXPECT_TRUE(backends_agree(
            scene, view + ", classification " + std::to_string(static_cast<int>(classification))));
      }
    }
  }
}

}  // namespace features_test
}  // namespace ovoid::test
