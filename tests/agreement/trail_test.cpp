// SPDX-License-Identifier: Apache-2.0
// A field with a trail on the cpu back end against the reference: two fields of one frame, sheet by
// sheet; and what a trail must not do.
#include <gtest/gtest.h>

#include "ovoid/error.h"
#include "support/agreement.h"
#include "support/scenes.h"
#include "support/where.h"

namespace ovoid::test {
namespace trail_test {

constexpr double kLeastDecibels = 60;  // as every picture

VolumeFunction waves(double phase) {
  return [phase](std::int64_t i, std::int64_t j, std::int64_t k) {
    const auto x = static_cast<double>(i), y = static_cast<double>(j), z = static_cast<double>(k);
    return 0.5 + 0.004 * x - 0.003 * y + 0.3 * std::cos(1.1 * x + 0.4 * z + phase) +
           0.15 * std::sin(0.9 * y - 0.5 * z);
  };
}

TransferFunction haze() {
  TransferFunction tf;
  tf.colors = {{0, {0.9, 0.2, 0.1}}, {1, {1.0, 0.9, 0.3}}};
  tf.opacities = {{0.45, 0}, {0.8, 0.15}};
  return tf;
}

struct TrailScene {
  TestScene scene;
  Trail trail;
};

TrailScene trail_scene(Mode mode, bool is_parallel, LatticeKind kind) {
  FieldSetup setup;
  setup.world_from_index = oblique_axes();
  setup.lattice = kind;
  const Index3 dims = kind == LatticeKind::kBodyCentred ? Index3{11, 9, 20} : Index3{14, 12, 13};
  TrailScene scene{small_scene(mode, is_parallel), {}};
  scene.scene.field = make_stored_field(dims, waves(0), {}, setup);
  scene.scene.look = semi_transparent_look(0, 1);
  scene.scene.look.mode = mode;
  scene.scene.look.isovalue = 0.6;
  scene.scene.camera = askew_camera(scene.scene.field, is_parallel, 1.3);
  scene.trail.field = make_stored_field(dims, waves(0.7), {}, setup);
  scene.trail.transfer_function = haze();
  return scene;
}

Frame draw_with_trail(const TrailScene& scene, Backend backend = Backend::kCpu) {
  const TestScene& s = scene.scene;
  return Renderer(backend, 2).render(with_trail(s.scene(), scene.trail), s.camera, s.options);
}

void expect_agreement(TrailScene scene, const std::string& name) {
  const Image expected = draw_with_trail(scene, Backend::kReference).image;
  for (const Evaluate how : {Evaluate::kGather, Evaluate::kScatter}) {
    scene.scene.options.evaluate = how;
    const ImageDifference found = compare(draw_with_trail(scene).image, expected);
    EXPECT_GE(found.psnr_db, kLeastDecibels) << name;
  }
  // There is something of the trail in it.
  EXPECT_LT(compare(draw(scene.scene).image, expected).psnr_db, 40) << name;
}

// Fails if a sheet of one field is composited before or behind the wrong one of the other, or one
// takes the other's numbers.
TEST(TrailAgreement, ModesViewsLattices) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const LatticeKind kind : {LatticeKind::kCartesian, LatticeKind::kBodyCentred}) {
    for (const bool is_parallel : {true, false}) {
      for (const Mode mode : {Mode::kComposite, Mode::kIsosurface})
        expect_agreement(trail_scene(mode, is_parallel, kind),
                         std::string(name_of(kind)) + (is_parallel ? ", parallel" : ""));
    }
  }
}

// Fails if sheets that are finished late, or pieces between sheets, come out of step.
TEST(TrailAgreement, DifferencesPiecesAndPlanes) {
  OVOID_NIGHTLY_ON_DEVICE();
  TrailScene scene = trail_scene(Mode::kComposite, false, LatticeKind::kCartesian);
  scene.scene.options.gradient = GradientMethod::kCentral;
  expect_agreement(scene, "central differences");
  scene.scene.options.classification = Classification::kPreintegrated;
  expect_agreement(scene, "central differences, pre-integrated");
  scene.scene.options.gradient = GradientMethod::kExact;
  const Vec3 center = scene.scene.field.world_bounds().center();
  const Vec3 normal = Vec3(0.3, -0.8, 0.5).normalized();
  scene.scene.options.clip_planes = {{normal, normal.dot(center)}};
  expect_agreement(scene, "pre-integrated, clipped");
  scene.scene.options.slab = Slab::kMean;
  expect_agreement(scene, "slab means");
}

// Fails if a patch of nodes, tiles that turn opaque or are skipped change the picture.
TEST(TrailAgreement, MagnifiedAndWithoutShortcuts) {
  OVOID_NIGHTLY_ON_DEVICE();
  TrailScene scene = trail_scene(Mode::kIsosurface, false, LatticeKind::kCartesian);
  scene.scene.camera = askew_camera(scene.scene.field, false, 6);
  scene.scene.options.width = 90;
  scene.scene.options.height = 70;
  const Image expected = draw_with_trail(scene).image;
  scene.scene.options.stop_opaque = false;
  scene.scene.options.skip_irrelevant = false;
  EXPECT_EQ(draw_with_trail(scene).image.rgba, expected.rgba);
  scene.scene.options.post_convolution = PostConvolution::kOff;
  EXPECT_EQ(draw_with_trail(scene).image.rgba, expected.rgba);
}

// A wall in front, and behind it what moved: nothing of the trail is seen through the wall.
TEST(Trail, NothingIsSeenThroughANearerSurface) {
  OVOID_NIGHTLY_ON_DEVICE();
  const Index3 dims{24, 24, 24};
  // Values are high in a wall of layers 14 to 18; the trail in a ball behind it, and one in front.
  const auto ball = [](double z0) {
    return [z0](std::int64_t i, std::int64_t j, std::int64_t k) {
      const Vec3 d(static_cast<double>(i) - 11.5, static_cast<double>(j) - 11.5,
                   static_cast<double>(k) - z0);
      return std::exp(-d.squaredNorm() / 8);
    };
  };
  for (const Mode mode : {Mode::kComposite, Mode::kIsosurface}) {
    TestScene scene;
    scene.field = make_field(dims, [](std::int64_t, std::int64_t, std::int64_t k) {
      return k >= 14 && k <= 18 ? 1.0 : 0.0;
    });
    scene.look = ramp_look({0, 1});
    scene.look.transfer_function.opacities = {{0.4, 0}, {0.5, 1}};
    scene.look.mode = mode;
    scene.look.isovalue = 0.5;
    const Vec3 center = scene.field.world_bounds().center();
    scene.camera = parallel_camera(center, {0, 0, -1}, 9);  // from large z
    scene.options = picture(40, 40);
    for (const Backend backend : {Backend::kCpu, Backend::kReference}) {
      Renderer renderer(backend, 2);
      // By the same back end: sheets lie on planes of samples, where each has its own limit.
      const Image alone =
          renderer.render({scene.field, scene.look}, scene.camera, scene.options).image;
      const auto with = [&](double z0) {
        return renderer
            .render(with_trail(scene.scene(), {make_field(dims, ball(z0)), haze()}), scene.camera,
                    scene.options)
            .image;
      };
      const Image behind = with(7);
      const ImageDifference hidden = compare(behind, alone);
      EXPECT_GE(hidden.psnr_db, 80) << static_cast<int>(mode);
      EXPECT_EQ(hidden.max_8bit, 0);
      EXPECT_LT(compare(with(21), alone).psnr_db, 45) << static_cast<int>(mode);
    }
  }
}

// Fails if a trail is drawn with what it does not fit.
TEST(Trail, RefusesOtherLatticesAndModes) {
  OVOID_NIGHTLY_ON_DEVICE();
  const TrailScene good = trail_scene(Mode::kComposite, true, LatticeKind::kCartesian);
  const auto refused = [](const TrailScene& scene, ErrorCode code) {
    for (const Backend backend : {Backend::kCpu, Backend::kReference}) {
      try {
        draw_with_trail(scene, backend);
        ADD_FAILURE() << "was drawn";
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), code) << error.what();
      }
    }
  };
  TrailScene bad = good;
  bad.trail.field = {};
  refused(bad, ErrorCode::kInvalidArgument);
  bad.trail.field = make_field({14, 12, 12}, waves(0));
  refused(bad, ErrorCode::kInvalidArgument);
  bad.trail.field = make_field({14, 12, 13}, waves(0));  // other axes
  refused(bad, ErrorCode::kInvalidArgument);
  for (const Mode mode : {Mode::kXray, Mode::kMaximum, Mode::kMean}) {
    bad = good;
    bad.scene.look.mode = mode;
    refused(bad, ErrorCode::kUnsupported);
  }
  bad = good;
  bad.scene.options.post_convolution = PostConvolution::kCubic;
  refused(bad, ErrorCode::kUnsupported);
}

}  // namespace trail_test
}  // namespace ovoid::test
