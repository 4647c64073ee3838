// SPDX-License-Identifier: Apache-2.0
// Kernel sets with a trail: the cpu back end against the reference, and what must come out.
#include <gtest/gtest.h>

#include <limits>
#include <memory>

#include "ovoid/error.h"
#include "support/agreement.h"
#include "support/kernel_sets.h"
#include "support/scenes.h"
#include "support/where.h"

namespace ovoid::test {
namespace kernel_trail_test {

constexpr double kLeastDecibels = 60;  // as every picture

KernelField shifted(KernelNumbers numbers, const Vec3& by, Reconstruction how,
                    int color_attribute = -1) {
  for (std::size_t i = 0; i < numbers.centers.size(); ++i)
    numbers.centers[i] += by[static_cast<int>(i % 3)];
  return {numbers.source(), how, 0, color_attribute};
}

TransferFunction trail_haze() {
  TransferFunction tf;
  tf.colors = {{0, {0.9, 0.2, 0.1}}, {1, {1.0, 0.9, 0.3}}};
  tf.opacities = {{0.1, 0.1}, {0.8, 0.5}};
  return tf;
}

struct MovingSet {
  TestScene scene;
  Trail trail;
};

// A set that has come from the side and the back, in four moments of unequal shares.
MovingSet moving_set(Mode mode, bool is_parallel, int color_attribute = -1) {
  const KernelNumbers numbers = jittered_ellipsoids(7);
  const KernelField field =
      shifted(numbers, Vec3::Zero(), Reconstruction::kNormalized, color_attribute);
  MovingSet set;
  set.scene = {field, askew_camera(field, is_parallel, 1.6), semi_transparent_look(0, 1),
               picture(70, 66)};
  set.scene.look.mode = mode;
  set.scene.look.isovalue = 0.62;
  set.scene.options.post_convolution = PostConvolution::kOff;
  set.trail.transfer_function = trail_haze();
  for (const double a : {0.1, 0.25, 0.4, 0.7})
    set.trail.moments.push_back(
        {shifted(numbers, Vec3(-0.9, 0.3, 0.5) * a, Reconstruction::kNormalized, color_attribute),
         1 - a});
  return set;
}

Image draw_moving(const MovingSet& set, Backend backend = Backend::kCpu) {
  const TestScene& s = set.scene;
  return Renderer(backend, 2).render(with_trail(s.scene(), set.trail), s.camera, s.options).image;
}

void expect_trails_agree(const MovingSet& set, const std::string& name) {
  const Image expected = draw_moving(set, Backend::kReference);
  EXPECT_GE(compare(draw_moving(set), expected).psnr_db, kLeastDecibels) << name;
  // There is something of the trail in it.
  EXPECT_LT(compare(draw(set.scene).image, expected).psnr_db, 40) << name;
}

// Fails if the sheets of one field come before or behind the wrong ones of the others, if moments
// are mixed with other shares, or if a subtile or layer is left out.
TEST(KernelTrailAgreement, ModesAndViews) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const bool is_parallel : {true, false}) {
    for (const Mode mode : {Mode::kComposite, Mode::kIsosurface}) {
      expect_trails_agree(moving_set(mode, is_parallel), is_parallel ? "parallel" : "perspective");
      expect_trails_agree(moving_set(mode, is_parallel, 1), "colours of their own");
    }
  }
}

TEST(KernelTrailAgreement, ClassificationsAndPlanes) {
  OVOID_NIGHTLY_ON_DEVICE();
  MovingSet set = moving_set(Mode::kComposite, false);
  const Vec3 normal = Vec3(0.3, -0.8, 0.5).normalized();
  set.scene.options.clip_planes = {{normal, normal.dot(set.scene.field.world_bounds().center())}};
  for (const Classification how :
       {Classification::kRefined, Classification::kSampled, Classification::kPreintegrated}) {
    set.scene.options.classification = how;
    expect_trails_agree(set, "way " + std::to_string(static_cast<int>(how)));
  }
  set.scene.options.slab = Slab::kMean;
  expect_trails_agree(set, "slab means");
}

// Fails if the plans of a field and its trail have other blocks: whatever the number of sheets.
TEST(KernelTrailAgreement, AnyNumberOfSheets) {
  OVOID_NIGHTLY_ON_DEVICE();
  MovingSet set = moving_set(Mode::kComposite, true);
  set.scene.options.width = 30;
  set.scene.options.height = 26;
  const double distance = set.scene.field.default_sampling_distance();
  for (int i = 0; i < 8; ++i) {
    set.scene.options.sampling_distance = distance * (0.5 + 0.05 * i);
    expect_trails_agree(set, std::to_string(i));
  }
}

// A sum, whose trail is one set with lower weights; and what levels make of large kernels.
TEST(KernelTrailAgreement, SumsAndLevels) {
  OVOID_NIGHTLY_ON_DEVICE();
  KernelNumbers numbers = balls_of_all_sizes(300, 0.02);
  MovingSet set = moving_set(Mode::kComposite, false);
  const KernelField field = shifted(numbers, Vec3::Zero(), Reconstruction::kSum);
  set.scene.field = field;
  set.scene.look = semi_transparent_look(0, field.value_range().hi);
  set.scene.camera = askew_camera(field, false, 1.6);
  for (float& weight : numbers.weights) weight *= 0.5F;
  set.trail.moments = {{shifted(numbers, {0.4, 0.1, -0.5}, Reconstruction::kSum), 3}};
  set.trail.transfer_function.colors = {{0, {0.9, 0.2, 0.1}}};
  set.trail.transfer_function.opacities = {{0, 0}, {0.5 * field.value_range().hi, 0.6}};
  expect_trails_agree(set, "sum");
  const Image exact = draw_moving(set);
  set.scene.options.post_convolution = PostConvolution::kAuto;
  EXPECT_GE(compare(draw_moving(set), exact).psnr_db, 45);
}

// Fails if what is behind limits is closed with them, stops come in the wrong order, or a part of
// a pixel is covered twice.
TEST(KernelTrailAgreement, LimitsHoldForTheFieldAlone) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const Mode mode : {Mode::kComposite, Mode::kIsosurface}) {
    MovingSet set = moving_set(mode, false);
    auto limits = std::make_shared<DepthLimits>(*random_limits(set.scene, 0.6));
    limits->coverage.clear();
    set.scene.options.depth_limits = limits;
    expect_trails_agree(set, "limits");
    for (std::size_t i = 0; i + 1 < limits->first.size(); ++i)
      limits->coverage.push_back(static_cast<float>(i % 5) / 4);
    expect_trails_agree(set, "parts of pixels");
  }
}

std::shared_ptr<DepthLimits> limits_everywhere(const TestScene& scene,
                                               const DepthLimits::Stop& stop) {
  auto limits = std::make_shared<DepthLimits>();
  limits->width = scene.options.width;
  limits->height = scene.options.height;
  limits->first = {0};
  for (int i = 1; i <= limits->width * limits->height; ++i) {
    limits->stops.push_back(stop);
    limits->first.push_back(static_cast<std::uint32_t>(i));
  }
  return limits;
}

// Fails if the trail shows through a nearer wall, or a wall behind it hides it.
TEST(KernelTrail, WallsHideWhatIsBehindThem) {
  OVOID_NIGHTLY_ON_DEVICE();
  MovingSet set = moving_set(Mode::kComposite, true);
  const auto with_wall = [&](float depth) {
    set.scene.options.depth_limits =
        limits_everywhere(set.scene, {depth, false, false, {0.2F, 0.3F, 0.4F, 1}});
    return draw_moving(set);
  };
  const Image front = with_wall(0);
  for (std::size_t i = 0; i < front.rgba.size(); i += 4) EXPECT_EQ(front.rgba[i + 1], 0.3F);
  const Image behind = with_wall(1e6F);
  set.scene.options.depth_limits = limits_everywhere(set.scene, {0, false, false, {}});
  const Image alone = draw_moving(set);
  double seen = 0;
  for (std::size_t i = 0; i < alone.rgba.size(); i += 4) {
    const float through = 1 - alone.rgba[i + 3];
    EXPECT_NEAR(behind.rgba[i + 1], alone.rgba[i + 1] + through * 0.3F, 1e-3F);
    seen = std::max(seen, static_cast<double>(alone.rgba[i + 3]));
  }
  EXPECT_GT(seen, 0.2);
}

// What stands still looks in its trail as it is: fails if shares do not add up, or what is there at
// all moments is thinned.
TEST(KernelTrail, OfWhatStandsStillIsItself) {
  OVOID_NIGHTLY_ON_DEVICE();
  MovingSet set = moving_set(Mode::kComposite, false);
  const KernelField still = *set.scene.field.kernels();
  set.trail.moments = {{still, 1}};
  const Image once = draw_moving(set);
  set.trail.moments = {{still, 0.3}, {still, 2}, {still, 0.7}};
  EXPECT_GE(compare(draw_moving(set), once).psnr_db, 90);
  // Where it was for half of the time it is half as dense: thin opacities are halved.
  set.trail.transfer_function.opacities = {{0, 0.02}};
  set.scene.options.depth_limits = limits_everywhere(set.scene, {0, false, false, {}});
  const Image whole = draw_moving(set);
  const KernelField elsewhere =
      shifted(jittered_ellipsoids(7), {50, 0, 0}, Reconstruction::kNormalized);
  set.trail.moments = {{still, 1}, {elsewhere, 1}};
  const Image half = draw_moving(set);
  for (std::size_t i = 3; i < half.rgba.size(); i += 4)
    EXPECT_NEAR(std::log1p(-half.rgba[i]), 0.5F * std::log1p(-whole.rgba[i]), 2e-4F);
}

// Fails if tiles that turn opaque or are skipped change the picture.
TEST(KernelTrail, ShortcutsChangeNothing) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const Mode mode : {Mode::kComposite, Mode::kIsosurface}) {
    MovingSet set = moving_set(mode, false);
    const Image expected = draw_moving(set);
    set.scene.options.stop_opaque = false;
    set.scene.options.skip_irrelevant = false;
    EXPECT_EQ(draw_moving(set).rgba, expected.rgba);
    EXPECT_EQ(
        Renderer(Backend::kCpu, 1)
            .render(with_trail(set.scene.scene(), set.trail), set.scene.camera, set.scene.options)
            .image.rgba,
        expected.rgba);
  }
}

TEST(KernelTrail, RefusesWhatIsNone) {
  OVOID_NIGHTLY_ON_DEVICE();
  const MovingSet good = moving_set(Mode::kComposite, true);
  const auto refused = [](const MovingSet& set, ErrorCode code) {
    for (const Backend backend : {Backend::kCpu, Backend::kReference}) {
      try {
        draw_moving(set, backend);
        ADD_FAILURE() << "was drawn";
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), code) << error.what();
      }
    }
  };
  MovingSet bad = good;
  bad.trail.moments.clear();
  refused(bad, ErrorCode::kInvalidArgument);
  bad = good;
  bad.trail.moments[1].field = {};
  refused(bad, ErrorCode::kInvalidArgument);
  for (const double share : {0.0, -1.0, std::numeric_limits<double>::infinity()}) {
    bad = good;
    bad.trail.moments[1].share = share;
    refused(bad, ErrorCode::kInvalidArgument);
  }
  bad = good;
  bad.trail.moments[2].field = shifted(jittered_ellipsoids(7), Vec3::Zero(), Reconstruction::kSum);
  refused(bad, ErrorCode::kInvalidArgument);
  bad.trail.moments[2].field =
      shifted(jittered_ellipsoids(7), Vec3::Zero(), Reconstruction::kNormalized, 1);
  refused(bad, ErrorCode::kInvalidArgument);
  bad = good;
  bad.scene.look.mode = Mode::kMaximum;
  refused(bad, ErrorCode::kUnsupported);
}

}  // namespace kernel_trail_test
}  // namespace ovoid::test
