// SPDX-License-Identifier: Apache-2.0
// Classification beyond the plain look-up, the cpu back end against the reference: pieces between
// sheets, and opacity by gradient.
#include <gtest/gtest.h>

#include <cmath>

#include "support/agreement.h"
#include "support/scenes.h"
#include "support/where.h"

namespace ovoid::test {
namespace classification_test {

// A gradient of the volume that is neither its least nor its greatest.
double typical_gradient(const TestVolume& volume) {
  return 0.2 * (volume.hi - volume.lo) / volume.field.default_sampling_distance();
}

void fade_by_gradient(Look& look, double gradient) {
  look.transfer_function.gradient_opacities = {
      {0.3 * gradient, 0}, {0.8 * gradient, 0.4, 0.3, 0.2}, {1.5 * gradient, 1}};
}

std::string view_name(bool is_parallel) { return is_parallel ? ", parallel" : ", perspective"; }

// Fails if the integrals, the ends beyond the table, or which sample comes before which is off.
TEST(Preintegrated, AgreesOnEveryVolumeAndLook) {
  OVOID_NIGHTLY_ON_DEVICE();
  OVOID_NOT_UNDER_ASAN();
  for (const TestVolume& volume : test_volumes()) {
    if (volume.name == "one sample") continue;  // has nothing before it
    for (const TestLook& look : test_looks(volume.lo, volume.hi)) {
      for (const double distance : {1.0, 3.0}) {
        const bool is_parallel = distance > 1;
        TestScene scene{volume.field, askew_camera(volume.field, is_parallel, 1.4), look.look,
                        picture(40, 34, distance * volume.field.default_sampling_distance())};
        scene.options.classification = Classification::kPreintegrated;
        EXPECT_TRUE(
            backends_agree(scene, volume.name + ", " + look.name + view_name(is_parallel), 0.002));
      }
    }
  }
}

TEST(Preintegrated, AgreesWithOtherOptions) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const bool is_parallel : {true, false}) {
    TestScene scene = small_scene(Mode::kComposite, is_parallel);
    scene.options.classification = Classification::kPreintegrated;
    const std::string view = "pre-integrated" + view_name(is_parallel);
    TestScene scattered = scene;
    scattered.options.evaluate = Evaluate::kScatter;
    EXPECT_TRUE(backends_agree(scattered, view + ", scatter"));
    TestScene central = scene;
    central.options.gradient = GradientMethod::kCentral;
    EXPECT_TRUE(backends_agree(central, view + ", central"));
    TestScene mean = scene;
    mean.options.slab = Slab::kMean;
    EXPECT_TRUE(backends_agree(mean, view + ", slab means"));
    TestScene clipped = scene;
    const Vec3 normal(-1.0, 0.6, 0.5);
    clipped.options.clip_planes = {{normal, normal.dot(scene.field.world_bounds().center()) - 0.7}};
    EXPECT_TRUE(backends_agree(clipped, view + ", clipped"));
    TestScene unlit = scene;
    unlit.look.shade = false;
    EXPECT_TRUE(backends_agree(unlit, view + ", no light"));
  }
}

// Fails if pieces that begin at the near plane have a front end before it.
TEST(Preintegrated, AgreesFromWithin) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const TestVolume& volume : test_volumes()) {
    if (volume.name == "one sample") continue;  // shows nothing
    TestScene scene{volume.field, askew_camera(volume.field, false, 1.4),
                    semi_transparent_look(volume.lo, volume.hi), picture(40, 34)};
    scene.camera.position += 0.85 * (scene.camera.focal_point - scene.camera.position);
    scene.camera.view_angle = 80;
    scene.options.classification = Classification::kPreintegrated;
    EXPECT_TRUE(backends_agree(scene, volume.name, 0.05));
  }
}

// Fails if the factor is taken from another gradient, or after the correction for the path.
TEST(GradientOpacity, AgreesOnEveryVolumeAndLook) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const TestVolume& volume : test_volumes()) {
    if (volume.name == "one sample") continue;  // has no gradient but rounding
    for (const TestLook& test_look : test_looks(volume.lo, volume.hi)) {
      TestScene scene{volume.field, askew_camera(volume.field, true, 1.4), test_look.look,
                      picture(40, 34)};
      fade_by_gradient(scene.look, typical_gradient(volume));
      EXPECT_TRUE(backends_agree(scene, volume.name + ", " + test_look.name, 0.01));
    }
  }
}

TEST(GradientOpacity, AgreesWithOtherOptions) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const bool is_parallel : {true, false}) {
    TestScene scene = small_scene(Mode::kComposite, is_parallel);
    const ValueRange range = scene.field.value_range();
    fade_by_gradient(scene.look, 0.2 * (range.hi - range.lo));
    const std::string view = "fading" + view_name(is_parallel);
    TestScene unlit = scene;
    unlit.look.shade = false;
    EXPECT_TRUE(backends_agree(unlit, view + ", no light"));
    TestScene scattered = scene;
    scattered.options.evaluate = Evaluate::kScatter;
    EXPECT_TRUE(backends_agree(scattered, view + ", scatter"));
    for (const GradientMethod method : {GradientMethod::kCentral, GradientMethod::kExact}) {
      TestScene other = scene;
      other.options.gradient = method;
      EXPECT_TRUE(backends_agree(other, view + ", another gradient"));
      other.look.shade = false;
      EXPECT_TRUE(backends_agree(other, view + ", another gradient, no light"));
    }
    TestScene both = scene;
    both.options.classification = Classification::kPreintegrated;
    EXPECT_TRUE(backends_agree(both, view + ", pre-integrated"));
    TestScene other_mode = scene;
    other_mode.look.mode = Mode::kMaximum;  // fading is of composite alone
    EXPECT_TRUE(backends_agree(other_mode, view + ", maximum"));
  }
}

// Fails if vector code reads a logarithmic table at another place than the table's own.
TEST(LogarithmicLook, Agrees) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const bool is_parallel : {true, false}) {
    for (const ValueScale scale : {ValueScale::kLog, ValueScale::kSymlog}) {
      for (const Classification classification :
           {Classification::kSampled, Classification::kPreintegrated}) {
        const bool is_log = scale == ValueScale::kLog;
        const Index3 dims{14, 13, 12};
        // Five decades, or both signs.
        const VolumeFunction shape = shells(dims);
        const LatticeField field =
            make_field(dims, [&](std::int64_t i, std::int64_t j, std::int64_t k) {
              const double s = shape(i, j, k);
              return is_log ? std::pow(10.0, 5 * s - 3) : std::sinh(12 * (s - 0.5));
            });
        TestScene scene{field, askew_camera(field, is_parallel), Look(), picture(32, 30)};
        TransferFunction& tf = scene.look.transfer_function;
        tf.scale = scale;
        tf.linear_width = 0.1;
        tf.color_space = ColorSpace::kLab;
        const double lo = is_log ? 1e-2 : -100;
        tf.colors = {{lo, {0.2, 0.3, 0.9}}, {1, {0.9, 0.9, 0.3}}, {100, {0.9, 0.2, 0.1}}};
        tf.opacities = {{lo, 0}, {0.5, 0.2}, {3, 0.02}, {100, 0.7}};
        scene.options.classification = classification;
        EXPECT_TRUE(backends_agree(
            scene, std::string(is_log ? "log" : "symlog") +
                       (classification == Classification::kSampled ? "" : ", pre-integrated") +
                       view_name(is_parallel)));
      }
    }
  }
}

}  // namespace classification_test
}  // namespace ovoid::test
