// SPDX-License-Identifier: Apache-2.0
// The published ways of post-convolution, the cpu back end against the reference.
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "ovoid/error.h"
#include "support/agreement.h"
#include "support/kernel_sets.h"
#include "support/scenes.h"
#include "support/tolerances.h"
#include "support/where.h"

namespace ovoid::test {
namespace published_ways_test {

struct View {
  bool is_parallel = true;
  int width = 32, height = 26;
  double thickness = 3;  // spacings along the view axis
  double pixels = 5.6;   // per spacing
};

// The middle of a lattice, and no more of it than a slab across the view axis: whatever groups and
// patches it falls into, their nodes' kernels are all there, so that both back ends take every
// pixel from nodes.
TestScene inner_scene(const Look& look, const View& at) {
  static const LatticeField field = make_stored_field({60, 60, 60}, shells({18, 18, 18}), {});
  // Those that take long are smaller to begin with, and show enough all the same.
  const int shrink = at.width < View{}.width ? kPublishedShrink : 1;
  const int width = at.width / shrink;
  const int height = at.height / shrink;
  TestScene scene{field, {}, look, picture(width, height, 0.5)};
  const double half_height = 0.5 * height / at.pixels;
  const Vec3 center = field.world_bounds().center();
  const Vec3 direction(0.48, -0.31, 0.82);
  scene.camera = at.is_parallel ? parallel_camera(center, direction, half_height)
                                : perspective_camera(center, direction, half_height, 40);
  const Vec3 forward = (center - scene.camera.position).normalized();
  const double middle = forward.dot(center);
  // Slabs do not end at the planes, where rounding would decide.
  const double half = 0.5 * at.thickness - 0.1;
  scene.options.clip_planes = {{forward, middle - half}, {-forward, -middle - half}};
  return scene;
}

// Pictures that pass for each other would say nothing about the ways.
void expect_other(const Image& image, const Image& off, const TestScene& scene,
                  const std::string& what) {
  const double peak = scene.look.mode == Mode::kXray ? greatest_color(off) : 1.0;
  EXPECT_LT(compare(image, off, peak).psnr_db, kAgreementPsnrDb - 5) << what;
}

// Each published way on both back ends, none of them for `off`'s.
void expect_ways_agree(TestScene scene, const std::string& name, double least_covered) {
  TestScene exact = scene;
  exact.options.post_convolution = PostConvolution::kOff;
  exact.options.spread = Spread::kGaussian;
  const Image off = draw(exact).image;
  for (const PostConvolution how : kPublishedWays) {
    scene.options.post_convolution = how;
    const std::string what = name + ", " + name_of(how);
    const Image reference = draw(scene, Backend::kReference).image;
    EXPECT_TRUE(agrees_with(reference, scene, what, least_covered));
    expect_other(reference, off, scene, what);
  }
}

// The look, and the options but for the way, are `change`'s.
void expect_agreement(const std::string& name, View at,
                      const std::function<void(TestScene&)>& change) {
  for (const bool is_parallel : {true, false}) {
    at.is_parallel = is_parallel;
    TestScene scene = inner_scene(semi_transparent_look(0, 1), at);
    change(scene);
    expect_ways_agree(scene, name + (is_parallel ? ", parallel" : ", perspective"), 0.2);
  }
}

TEST(PublishedWays, LatticesAgreeInComposite) {
  OVOID_NOT_UNDER_TSAN();
  OVOID_NIGHTLY_ON_DEVICE();
  expect_agreement("composite", {}, [](TestScene&) {});
}

TEST(PublishedWays, LatticesAgreeOnOpaquePeaks) {
  OVOID_NOT_UNDER_TSAN();
  OVOID_NIGHTLY_ON_DEVICE();
  expect_agreement("peak", {.thickness = 4},
                   [](TestScene& scene) { scene.look = test_looks(0, 1).front().look; });
}

// So few pixels per node that a patch has nearly as many nodes as there may be.
TEST(PublishedWays, LatticesAgreeOnDenseNodes) {
  OVOID_NOT_UNDER_TSAN();
  OVOID_NIGHTLY_ON_DEVICE();
  expect_agreement("dense nodes", {.pixels = 2.2}, [](TestScene&) {});
}

TEST(PublishedWays, LatticesAgreeInXray) {
  OVOID_NOT_UNDER_TSAN();
  OVOID_NIGHTLY_ON_DEVICE();
  expect_agreement("x-ray", {}, [](TestScene& scene) { scene.look.mode = Mode::kXray; });
}

TEST(PublishedWays, LatticesAgreeInMaximum) {
  OVOID_NOT_UNDER_TSAN();
  OVOID_NIGHTLY_ON_DEVICE();
  expect_agreement("maximum", {}, [](TestScene& scene) { scene.look.mode = Mode::kMaximum; });
}

TEST(PublishedWays, LatticesAgreeInMean) {
  OVOID_NIGHTLY_ON_DEVICE();
  OVOID_NOT_UNDER_TSAN();
  expect_agreement("mean", {}, [](TestScene& scene) { scene.look.mode = Mode::kMean; });
}

TEST(PublishedWays, LatticesAgreeOnIsosurfaces) {
  OVOID_NOT_UNDER_TSAN();
  OVOID_NIGHTLY_ON_DEVICE();
  expect_agreement("isosurface", {}, [](TestScene& scene) {
    scene.look.mode = Mode::kIsosurface;
    scene.look.isovalue = 0.55;
  });
}

TEST(PublishedWays, LatticesAgreeOnPieces) {
  OVOID_NOT_UNDER_TSAN();
  OVOID_NIGHTLY_ON_DEVICE();
  expect_agreement("pre-integrated", {}, [](TestScene& scene) {
    scene.options.classification = Classification::kPreintegrated;
  });
}

TEST(PublishedWays, LatticesAgreeOnDifferences) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  OVOID_NIGHTLY_ON_DEVICE();
  expect_agreement("central", {.width = 26, .height = 22, .thickness = 3},
                   [](TestScene& scene) { scene.options.gradient = GradientMethod::kCentral; });
}

TEST(PublishedWays, LatticesAgreeOnDifferencesOfPieces) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  OVOID_NIGHTLY_ON_DEVICE();
  expect_agreement("central, pre-integrated", {.width = 26, .height = 22, .thickness = 3},
                   [](TestScene& scene) {
                     scene.options.gradient = GradientMethod::kCentral;
                     scene.options.classification = Classification::kPreintegrated;
                   });
}

// The reference integrates each of a pixel's 36 nodes along the slab.
TEST(PublishedWays, LatticesAgreeOnMeansOfSlabs) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  OVOID_NIGHTLY_ON_DEVICE();
  expect_agreement("mean slabs", {.width = 18, .height = 16, .thickness = 2},
                   [](TestScene& scene) { scene.options.slab = Slab::kMean; });
}

TEST(PublishedWays, LatticesAgreeOnBilinearSpread) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  OVOID_NIGHTLY_ON_DEVICE();
  expect_agreement("spread", {.width = 26, .height = 22, .thickness = 3},
                   [](TestScene& scene) { scene.options.spread = Spread::kBilinear; });
}

TEST(PublishedWays, LatticesAgreeOnBilinearSpreadInXray) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  OVOID_NIGHTLY_ON_DEVICE();
  expect_agreement("spread x-ray", {.width = 30, .height = 24, .thickness = 3},
                   [](TestScene& scene) {
                     scene.options.spread = Spread::kBilinear;
                     scene.look.mode = Mode::kXray;
                   });
}

TEST(PublishedWays, LatticesAgreeOnBilinearSpreadOfIsosurfaces) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  OVOID_NIGHTLY_ON_DEVICE();
  expect_agreement("spread isosurface", {.width = 30, .height = 24, .thickness = 3},
                   [](TestScene& scene) {
                     scene.options.spread = Spread::kBilinear;
                     scene.look.mode = Mode::kIsosurface;
                     scene.look.isovalue = 0.55;
                   });
}

TEST(PublishedWays, LatticesAgreeOnBilinearSpreadOfPieces) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  OVOID_NIGHTLY_ON_DEVICE();
  expect_agreement("spread pre-integrated", {.width = 26, .height = 22, .thickness = 3},
                   [](TestScene& scene) {
                     scene.options.spread = Spread::kBilinear;
                     scene.options.classification = Classification::kPreintegrated;
                   });
}

// The spread is a weighted mean of a lattice's samples.
TEST(PublishedWays, SpreadIsOfNormalizedLatticesAlone) {
  OVOID_NOT_UNDER_TSAN();
  OVOID_NIGHTLY_ON_DEVICE();
  TestScene scene = inner_scene(semi_transparent_look(0, 1), {});
  scene.options.post_convolution = PostConvolution::kCubic;
  scene.options.spread = Spread::kBilinear;
  const LatticeField sum =
      make_stored_field({8, 8, 8}, shells({8, 8, 8}), {}, {.reconstruction = Reconstruction::kSum});
  for (const Field& field :
       {Field(sum), Field(KernelField(jittered_balls(3).source(), Reconstruction::kNormalized))}) {
    scene.field = field;
    for (const Backend backend : {Backend::kCpu, Backend::kReference}) {
      try {
        draw(scene, backend);
        ADD_FAILURE() << "accepted";
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::kUnsupported);
        EXPECT_EQ(std::string(error.what()).substr(0, 23), "spread: bilinear is for");
      }
    }
  }
}

// Magnified until kernels go to several levels; in perspective one kernel's own sheets lie on both
// sides of a level's bound.
void expect_sets_agree(const std::string& name, const KernelField& field,
                       const std::function<void(TestScene&)>& change) {
  for (const bool is_parallel : {true, false}) {
    TestScene scene{field, askew_camera(field, is_parallel, 2.5), semi_transparent_look(0, 1),
                    picture(64, 52)};
    scene.options.slab = Slab::kAuto;
    change(scene);
    expect_ways_agree(scene, name + (is_parallel ? ", parallel" : ", perspective"), 0.3);
  }
}

TEST(PublishedWays, SetsAgree) {
  OVOID_NOT_UNDER_TSAN();
  expect_sets_agree("ellipsoids",
                    KernelField(jittered_ellipsoids(7).source(), Reconstruction::kNormalized),
                    [](TestScene&) {});
}

TEST(PublishedWays, SetsAgreeOnAnotherColor) {
  OVOID_NOT_UNDER_TSAN();
  OVOID_NIGHTLY_ON_DEVICE();
  const KernelField field(jittered_ellipsoids(7).source(), Reconstruction::kNormalized, 0, 1);
  expect_sets_agree("own colour", field, [&](TestScene& scene) {
    scene.look.color_function = ramp_look(field.color_range()).transfer_function;
  });
}

TEST(PublishedWays, SetsAgreeInXray) {
  OVOID_NOT_UNDER_TSAN();
  OVOID_NIGHTLY_ON_DEVICE();
  expect_sets_agree("sums, x-ray",
                    KernelField(jittered_ellipsoids(7, 2.5).source(), Reconstruction::kSum),
                    [](TestScene& scene) { scene.look.mode = Mode::kXray; });
}

TEST(PublishedWays, SetsAgreeOnIsosurfaces) {
  OVOID_NOT_UNDER_TSAN();
  OVOID_NIGHTLY_ON_DEVICE();
  expect_sets_agree("balls, isosurface",
                    KernelField(jittered_balls(7).source(), Reconstruction::kNormalized),
                    [](TestScene& scene) {
                      scene.look.mode = Mode::kIsosurface;
                      scene.look.isovalue = 0.5;
                    });
}

}  // namespace published_ways_test
}  // namespace ovoid::test
