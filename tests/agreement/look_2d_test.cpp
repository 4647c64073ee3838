// SPDX-License-Identifier: Apache-2.0
// Looks by value and gradient: the cpu back end against the reference, and both against the
// one-dimensional look that a table says the same as.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ovoid/error.h"
#include "support/agreement.h"
#include "support/kernel_sets.h"
#include "support/scenes.h"
#include "support/where.h"

namespace ovoid::test {
namespace look_2d_test {

// Regions that every volume has something in: flat insides of low values, and boundaries.
Look look_by_gradient(double lo, double hi, double spacing) {
  const double span = hi > lo ? hi - lo : 1;
  const auto at = [&](double share) { return lo + share * span; };
  const double steep = span / spacing;
  Look look = semi_transparent_look(lo, lo + span);
  look.occlusion = look.shadows = 0;
  look.transfer_function_2d = TransferFunction2D({{.values = {at(-0.1), at(0.7)},
                                                   .gradients = {0, 0.2 * steep},
                                                   .rgb = {0.2, 0.5, 1},
                                                   .opacity = 0.15,
                                                   .softness = 0.4},
                                                  {.values = {at(0.2), at(1.1)},
                                                   .gradients = {0.02 * steep, 0.8 * steep},
                                                   .rgb = {1, 0.8, 0.3},
                                                   .opacity = 0.6,
                                                   .softness = 0.6,
                                                   .foot = 0.2},
                                                  {.shape = LookRegion::Shape::kGaussian,
                                                   .values = {at(0.4), at(1.2)},
                                                   .gradients = {0, 0.5 * steep},
                                                   .rgb = {0.9, 0.2, 0.1},
                                                   .opacity = 0.3}});
  return look;
}

Look look_by_gradient(const Field& field) {
  const ValueRange range = field.value_range();
  return look_by_gradient(range.lo, range.hi, field.default_sampling_distance());
}

TestScene scene_by_gradient(bool is_parallel) {
  TestScene scene = small_scene(Mode::kComposite, is_parallel);
  scene.look = look_by_gradient(scene.field);
  return scene;
}

// Fails if the place in the table is off along either axis, or the gradient is another's.
TEST(Look2D, AgreesOnEveryVolume) {
  OVOID_NOT_ON_DEVICE("has no 2-D transfer function");
  for (const TestVolume& volume : test_volumes()) {
    if (volume.name == "one sample") continue;  // has no gradient but rounding
    for (const bool is_parallel : {true, false}) {
      TestScene scene{
          volume.field, askew_camera(volume.field, is_parallel, 1.4),
          look_by_gradient(volume.lo, volume.hi, volume.field.default_sampling_distance()),
          picture(36, 30)};
      scene.options.post_convolution = PostConvolution::kOff;
      for (const Classification how : {Classification::kRefined, Classification::kSampled}) {
        scene.options.classification = how;
        EXPECT_TRUE(backends_agree(scene, volume.name, 0.01));
      }
    }
  }
}

// Fails if one of the ways to a sample's gradient misses the look.
TEST(Look2D, AgreesWithOtherOptions) {
  OVOID_NOT_ON_DEVICE("has no 2-D transfer function");
  const Vec3 normal(-1.0, 0.6, 0.5);
  const std::pair<const char*, void (*)(TestScene&)> kChanges[] = {
      {"no light", [](TestScene& s) { s.look.shade = false; }},
      {"sampled, no light",
       [](TestScene& s) {
         s.look.shade = false;
         s.options.classification = Classification::kSampled;
       }},
      {"central", [](TestScene& s) { s.options.gradient = GradientMethod::kCentral; }},
      {"exact", [](TestScene& s) { s.options.gradient = GradientMethod::kExact; }},
      {"scatter",
       [](TestScene& s) {
         s.options.classification = Classification::kSampled;
         s.options.evaluate = Evaluate::kScatter;
       }},
      {"lattice sheets", [](TestScene& s) { s.options.sheets = Sheets::kLattice; }},
  };
  for (const bool is_parallel : {true, false}) {
    for (const auto& [name, change] : kChanges) {
      TestScene scene = scene_by_gradient(is_parallel);
      change(scene);
      EXPECT_TRUE(backends_agree(scene, name));
    }
    TestScene clipped = scene_by_gradient(is_parallel);
    clipped.options.clip_planes = {
        {normal, normal.dot(clipped.field.world_bounds().center()) - 0.7}};
    EXPECT_TRUE(backends_agree(clipped, "clipped", 0.02));
  }
}

TEST(Look2D, AgreesOnSetsOfKernels) {
  OVOID_NOT_ON_DEVICE("has no 2-D transfer function");
  const KernelField field(jittered_ellipsoids(8).source(), Reconstruction::kNormalized);
  for (const bool is_parallel : {true, false}) {
    TestScene scene{field, askew_camera(field, is_parallel, 1.2), look_by_gradient(field),
                    picture(36, 30)};
    EXPECT_TRUE(backends_agree(scene, "kernels"));
    scene.options.classification = Classification::kSampled;
    EXPECT_TRUE(backends_agree(scene, "kernels, sampled"));
  }
}

// Fails if volumes that are mixed take each other's function.
TEST(Look2D, AgreesWithAFurtherVolume) {
  OVOID_NOT_ON_DEVICE("has no 2-D transfer function");
  TestScene scene = scene_by_gradient(true);
  Look plain = semi_transparent_look(scene.field.value_range().lo, scene.field.value_range().hi);
  plain.occlusion = plain.shadows = 0;
  TestScene other = scene;
  other.look = plain;
  for (TestScene* const one : {&scene, &other}) {
    const Look& beside = one == &scene ? plain : scene.look;
    one->further = {{scene.field, beside}};
    EXPECT_TRUE(backends_agree(*one, one == &scene ? "2-D first" : "2-D beside"));
  }
}

// Fails if something is left out that only some gradients show.
TEST(Look2D, SkippingChangesNoByte) {
  OVOID_NOT_ON_DEVICE("has no 2-D transfer function");
  for (const bool is_refined : {true, false}) {
    TestScene scene = scene_by_gradient(false);
    const ValueRange range = scene.field.value_range();
    const double middle = 0.5 * (static_cast<double>(range.lo) + range.hi);
    scene.look.transfer_function_2d = TransferFunction2D(
        {{.values = {middle, range.hi}, .gradients = {0.01, 1e3}, .opacity = 0.9}});
    scene.options.classification = is_refined ? Classification::kRefined : Classification::kSampled;
    const Image skipped = draw(scene).image;
    scene.options.skip_irrelevant = false;
    scene.options.stop_opaque = false;
    EXPECT_TRUE(draw(scene).image == skipped);
    EXPECT_TRUE(
        std::any_of(skipped.rgba.begin(), skipped.rgba.end(), [](float x) { return x > 0.1F; }));
  }
}

// A table that says at every gradient what a look says. What lies between two entries, and the
// steps of pieces, differ by little.
TEST(Look2D, IsTheLookThatItRepeatsAlongTheGradient) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const bool is_refined : {true, false}) {
    for (const Backend backend : {Backend::kReference, Backend::kCpu}) {
      TestScene scene = small_scene(Mode::kComposite, true);
      scene.look.occlusion = scene.look.shadows = 0;
      scene.options.classification =
          is_refined ? Classification::kRefined : Classification::kSampled;
      const Image expected = draw(scene, backend).image;
      const TransferFunction& tf = scene.look.transfer_function;
      const TransferFunction2D::Axis values{tf.lo(), tf.hi(), 4096};
      std::vector<TransferFunction2D::Rgba> entries;
      for (int row = 0; row < 2; ++row) {
        for (int i = 0; i < values.count; ++i) {
          const double value = std::lerp(values.first, values.last, i / 4095.0);
          const Rgb color = tf.color_at(value);
          entries.push_back({static_cast<float>(color[0]), static_cast<float>(color[1]),
                             static_cast<float>(color[2]),
                             static_cast<float>(tf.opacity_at(value))});
        }
      }
      scene.look.transfer_function_2d = TransferFunction2D(values, {0, 1, 2}, entries);
      const Image image = draw(scene, backend).image;
      float greatest = 0;
      for (std::size_t i = 0; i < image.rgba.size(); ++i)
        greatest = std::max(greatest, std::abs(image.rgba[i] - expected.rgba[i]));
      EXPECT_LE(greatest, 1.0F / 255) << is_refined << static_cast<int>(backend);
    }
  }
}

// Fails if something is silently drawn otherwise than it was asked for.
TEST(Look2D, RefusesWhatHasNoGradient) {
  OVOID_NIGHTLY_ON_DEVICE();
  const auto error_of = [](void (*change)(TestScene&)) -> std::string {
    TestScene scene = scene_by_gradient(true);
    change(scene);
    try {
      draw(scene, Backend::kCpu);
    } catch (const Error& error) {
      return error.what();
    }
    return "drawn";
  };
  EXPECT_NE(error_of([](TestScene& s) { s.look.mode = Mode::kMaximum; }).find("mode composite"),
            std::string::npos);
  EXPECT_NE(error_of([](TestScene& s) {
              s.options.classification = Classification::kPreintegrated;
            }).find("pre-integrated"),
            std::string::npos);
  EXPECT_NE(error_of([](TestScene& s) { s.look.shadows = 0.5; }).find("both must be 0"),
            std::string::npos);
  EXPECT_NE(error_of([](TestScene& s) {
              s.look.transfer_function.gradient_opacities = {{0, 0}, {1, 1}};
            }).find("gradient_opacities"),
            std::string::npos);
}

}  // namespace look_2d_test
}  // namespace ovoid::test
