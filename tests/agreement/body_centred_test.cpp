// SPDX-License-Identifier: Apache-2.0
// Body-centred lattices on the cpu back end against the reference: the same stages as for Cartesian
// ones, summed over two sublattices.
#include <gtest/gtest.h>

#include "support/agreement.h"
#include "support/scenes.h"
#include "support/where.h"
#include "view/plan/frame_plan.h"

namespace ovoid::test {
namespace body_centred_test {

// Smooth in space, whichever sublattice a sample is of; no two crests are equally high.
VolumeFunction waves(const Index3& dims) {
  const LatticeGeometry lattice{dims, Affine3::Identity(), LatticeKind::kBodyCentred};
  return [lattice](std::int64_t i, std::int64_t j, std::int64_t k) {
    const Vec3 u = lattice.index_position({i, j, k});
    const double slope = 0.004 * u.x() + 0.003 * u.y() - 0.005 * u.z();
    return 0.5 + slope + 0.3 * std::cos(1.1 * u.x() + 0.4 * u.z()) +
           0.15 * std::sin(0.9 * u.y() - u.z());
  };
}

TestScene body_centred_scene(Mode mode, bool is_parallel, const FieldSetup& changes = {}) {
  const Index3 dims{11, 9, 20};
  FieldSetup setup = changes;
  setup.world_from_index = oblique_axes();
  setup.lattice = LatticeKind::kBodyCentred;
  TestScene scene = small_scene(mode, is_parallel);
  scene.field = make_stored_field(dims, waves(dims), {ScalarType::kFloat32, 10, 50}, setup);
  scene.camera = askew_camera(scene.field, is_parallel, 1.3);
  return scene;
}

std::string scene_name(const TestScene& scene) {
  return std::string("body-centred, ") + kModeNames[static_cast<int>(scene.look.mode)];
}

class BodyCentredMode : public ::testing::TestWithParam<int> {
 protected:
  Mode mode() const { return kModes[GetParam()]; }
  std::string name() const { return std::string("body-centred, ") + kModeNames[GetParam()]; }
};

// Fails if a sublattice is left out, misplaced, or weighed by itself and not with the other.
TEST_P(BodyCentredMode, SlabsReconstructionsEvaluations) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const bool is_parallel : {true, false}) {
    for (const Reconstruction reconstruction :
         {Reconstruction::kNormalized, Reconstruction::kSum}) {
      for (const Slab slab : {Slab::kMid, Slab::kMean}) {
        FieldSetup setup;
        setup.reconstruction = reconstruction;
        TestScene scene = body_centred_scene(mode(), is_parallel, setup);
        scene.options.slab = slab;
        expect_agreement_however_evaluated(
            scene, name() + (is_parallel ? ", parallel" : ", perspective") +
                       (reconstruction == Reconstruction::kSum ? ", sum" : "") +
                       (slab == Slab::kMean ? ", slab means" : ""));
      }
    }
  }
}

// Fails if the gradient's matrix is not the one of both sublattices, or its correction is not left
// out where the plain derivative was asked for.
TEST_P(BodyCentredMode, Gradients) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const GradientMethod method : {GradientMethod::kExact, GradientMethod::kCentral}) {
    for (const Slab slab : {Slab::kMid, Slab::kMean}) {
      TestScene scene = body_centred_scene(mode(), slab == Slab::kMid);
      scene.options.gradient = method;
      scene.options.slab = slab;
      expect_agreement_however_evaluated(
          scene, name() + (method == GradientMethod::kExact ? ", exact" : ", central"));
    }
  }
}

// Fails if missing samples of one sublattice hide or stand for those of the other.
TEST_P(BodyCentredMode, Holes) {
  OVOID_NIGHTLY_ON_DEVICE();
  const Index3 dims{11, 9, 20};
  FieldSetup setup;
  setup.lattice = LatticeKind::kBodyCentred;
  const VolumeFunction whole = waves(dims);
  TestScene scene = body_centred_scene(mode(), false);
  scene.field = make_stored_field(
      dims,
      [&](std::int64_t i, std::int64_t j, std::int64_t k) {
        return (7 * i + 11 * j + 13 * k) % 17 == 0 || i + j + k < 9 ? kMissing : whole(i, j, k);
      },
      {ScalarType::kFloat32, 10, 50}, setup);
  scene.camera = askew_camera(scene.field, false, 1.3);
  expect_agreement_however_evaluated(scene, name() + ", holes");
}

INSTANTIATE_TEST_SUITE_P(Modes, BodyCentredMode, ::testing::Range(0, 5),
                         [](const auto& test) { return kModeNames[test.param]; });

// Fails if widened kernels, other widths or bricks of their own take another path to other numbers.
TEST(BodyCentredAgreement, KernelsAndSources) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const LatticeKernel& kernel :
       {LatticeKernel{0.4, 4}, {0.8, 4}, {0.5, 2}, kBSplineKernel, kCatmullRomKernel}) {
    FieldSetup setup;
    setup.kernel = kernel;
    for (const auto how : {Reconstruction::kNormalized, Reconstruction::kSum}) {
      setup.reconstruction = how;
      TestScene scene = body_centred_scene(Mode::kComposite, true, setup);
      expect_agreement_however_evaluated(
          scene, std::string("body-centred, ") + name_of(kernel.kind) + ", sigma " +
                     std::to_string(kernel.sigma) + (how == Reconstruction::kSum ? ", sum" : ""));
      scene.options = picture(96, 80);  // no kernel is widened
      EXPECT_TRUE(backends_agree(scene, std::string("body-centred, magnified, ") +
                                            name_of(kernel.kind) + ", sigma " +
                                            std::to_string(kernel.sigma)));
    }
  }
  TestScene scene = body_centred_scene(Mode::kComposite, false);
  const double half_height = 8 * 3.0 * scene.field.default_sampling_distance();
  scene.camera = perspective_camera(scene.field.world_bounds().center(), {0.48, -0.31, 0.82},
                                    half_height, 4 * half_height);
  scene.options = picture(20, 18, 1.5);
  expect_agreement_however_evaluated(scene, "body-centred, minified", 0.02);

  const Index3 dims{21, 19, 37};  // several bricks of 8 cells
  FieldSetup setup;
  setup.lattice = LatticeKind::kBodyCentred;
  const VolumeFunction shape = waves(dims);
  scene.field = make_field(
      dims,
      [&](std::int64_t i, std::int64_t j, std::int64_t k) { return 10 + 40 * shape(i, j, k); },
      setup);
  scene.camera = askew_camera(scene.field, false, 1.3);
  scene.options = picture(40, 36);
  expect_agreement_however_evaluated(scene, "body-centred, bricks with margins");
}

// Fails if nodes lie farther apart than the narrower kernels allow, or take one sublattice.
TEST(BodyCentredAgreement, Magnified) {
  OVOID_NIGHTLY_ON_DEVICE();
  TestScene magnified = body_centred_scene(Mode::kComposite, false);
  magnified.camera = askew_camera(magnified.field, false, 8);
  magnified.options = picture(96, 80);
  magnified.options.post_convolution = PostConvolution::kOff;
  EXPECT_TRUE(agrees_with(draw(magnified, Backend::kReference).image, magnified,
                          scene_name(magnified) + ", magnified", 0.5));
  // So small a lattice is mostly edge, where pieces have pixels of their own at both ends.
  magnified.options.classification = Classification::kSampled;
  const std::int64_t num_samples = draw(magnified).profile.samples_reconstructed;
  for (const bool shade : {false, true}) {
    magnified.look.shade = shade;
    magnified.options.post_convolution = PostConvolution::kOff;
    const Image every = draw(magnified).image;
    magnified.options.post_convolution = PostConvolution::kAuto;
    const Frame fast = draw(magnified);
    EXPECT_GE(compare(fast.image, every).psnr_db, view::kNodeDecibels) << shade;
    EXPECT_LT(fast.profile.samples_reconstructed, num_samples);
  }
}

// Fails if nodes of the published ways are not a spacing apart, or samples of one sublattice are
// not spread. In the lattice's middle, where every pixel is taken from nodes.
TEST(BodyCentredAgreement, PublishedWays) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NIGHTLY_ON_DEVICE();
  const Index3 dims{34, 34, 68};
  FieldSetup setup;
  setup.lattice = LatticeKind::kBodyCentred;
  const LatticeField field = make_stored_field(dims, waves(dims), {}, setup);
  const Vec3 center = field.world_bounds().center();
  TestScene scene{field, parallel_camera(center, {0.48, -0.31, 0.82}, 3.2 / kPublishedShrink),
                  semi_transparent_look(0, 1),
                  picture(48 / kPublishedShrink, 40 / kPublishedShrink, 0.4)};
  const Vec3 forward = (center - scene.camera.position).normalized();
  scene.options.clip_planes = {{forward, forward.dot(center) - 1.1},
                               {-forward, -forward.dot(center) - 1.1}};
  for (const PostConvolution how : kPublishedWays) {
    for (const Spread spread : {Spread::kGaussian, Spread::kBilinear}) {
      scene.options.post_convolution = how;
      scene.options.spread = spread;
      EXPECT_TRUE(backends_agree(scene, scene_name(scene) + ", " + name_of(how) +
                                            (spread == Spread::kBilinear ? ", spread" : "")));
    }
  }
}

}  // namespace body_centred_test
}  // namespace ovoid::test
