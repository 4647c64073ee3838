// SPDX-License-Identifier: Apache-2.0
#include "render/passes/plane_frame.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "ovoid/error.h"
#include "render/passes/test_plane_frame.h"
#include "support/compare.h"
#include "support/numbers.h"

namespace ovoid::value_plane_test {
namespace value_plane_test {

ErrorCode code_of(const std::function<void()>& work, const std::string& start = {}) {
  try {
    work();
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).substr(0, start.size()), start);
    return error.code();
  }
  ADD_FAILURE() << "accepted; expected: " << start;
  return ErrorCode::kFileFormat;
}

// Fails if opacity or light of the look reach the plane, or a see-through volume leaves anything.
TEST(ValuePlane, SeeThroughVolumeLeavesThePlaneAlone) {
  PlaneScene scene = linear_scene(0);
  const Image removed = draw(scene).image;
  scene.plane.front = PlaneFront::kShown;
  scene.look.shade = true;
  EXPECT_EQ(draw(scene).image, removed);
  for (std::size_t i = 3; i < removed.rgba.size(); i += 4)
    ASSERT_TRUE(removed.rgba[i] == 0 || removed.rgba[i] == 1);
}

// Fails if the half in front is drawn, the wrong half is, or the plane is not opaque.
TEST(ValuePlane, RemovedFrontIsTheClippedFrameOffThePlane) {
  for (const Camera& camera : cameras()) {
    for (const ValuePlane& plane : planes()) {
      PlaneScene scene = linear_scene(0.2);
      scene.camera = camera;
      scene.plane = plane;
      const Vec3 axis = camera.focal_point - camera.position;
      const double side = camera.parallel_projection
                              ? plane.normal.dot(axis)
                              : plane.offset - plane.normal.dot(camera.position);
      const Image behind = draw_volume(scene, side > 0 ? 1 : -1);
      const Image alone = draw_plane(scene);
      const Image image = draw(scene).image;
      for (std::size_t i = 0; i < image.depth.size(); ++i) {
        const Image& expected = alone.rgba[4 * i + 3] > 0 ? alone : behind;
        ASSERT_EQ(image.depth[i], expected.depth[i]) << i;
        ASSERT_EQ(image.front_depth[i], expected.front_depth[i]) << i;
        for (std::size_t c = 4 * i; c < 4 * i + 4; ++c)
          ASSERT_EQ(image.rgba[c], expected.rgba[c]) << i;
      }
    }
  }
}

// Fails if the plane is drawn over what is in front of it, or light and opacity of the half in
// front are not the look's.
TEST(ValuePlane, ShownFrontIsBeforeThePlane) {
  for (const double opacity : {0.1, 1.0}) {
    for (const Camera& camera : cameras()) {
      PlaneScene scene = linear_scene(opacity);
      scene.options.classification = Classification::kSampled;  // halves of pieces have own steps
      scene.camera = camera;
      scene.look.shade = true;
      scene.plane.front = PlaneFront::kShown;
      const Vec3 axis = camera.focal_point - camera.position;
      const Image front = draw_volume(scene, scene.plane.normal.dot(axis) > 0 ? -1 : 1);
      const Image whole = draw_volume(scene);
      const Image alone = draw_plane(scene);
      const Image image = draw(scene).image;
      int num_hidden = 0;
      for (std::size_t i = 0; i < image.depth.size(); ++i) {
        const bool is_on = alone.rgba[4 * i + 3] > 0;
        const double rest = 1.0 - static_cast<double>(front.rgba[4 * i + 3]);
        const bool is_hidden = rest <= 1 - RenderOptions::kOpaque;
        num_hidden += is_on && is_hidden ? 1 : 0;
        for (std::size_t c = 4 * i; c < 4 * i + 4; ++c) {
          // Off the plane a ray is on one side of it in the field's box; of a sheet that the plane
          // cuts, the paths add up but for the rounding of floats.
          const double expected =
              !is_on ? whole.rgba[c] : front.rgba[c] + (is_hidden ? 0.0 : rest * alone.rgba[c]);
          ASSERT_NEAR(image.rgba[c], expected, 2e-6) << i;
        }
        const Image& of_depth = front.depth[i] < kInfinityF ? front : is_on ? alone : whole;
        // Where a sheet is cut, the half behind may reach 1/2 by itself on the next one.
        const float cut = is_on ? 0.0F : 1.0F;
        ASSERT_TRUE(image.depth[i] == of_depth.depth[i] ||
                    image.depth[i] == of_depth.depth[i] + cut)
            << i;
        if (front.front_depth[i] < kInfinityF) {
          ASSERT_EQ(image.front_depth[i], front.front_depth[i]) << i;
        } else if (is_on) {
          ASSERT_EQ(image.front_depth[i], alone.depth[i]) << i;
        } else {
          ASSERT_EQ(image.front_depth[i] < kInfinityF, whole.front_depth[i] < kInfinityF) << i;
        }
      }
      EXPECT_EQ(num_hidden > 100, opacity == 1.0);
    }
  }
}

// Fails if an isosurface behind the plane shows through, or one in front is lost.
TEST(ValuePlane, Isosurfaces) {
  PlaneScene scene = linear_scene();
  scene.look.mode = Mode::kIsosurface;
  scene.look.isovalue = 0.52;
  scene.plane.front = PlaneFront::kShown;
  int num_over = 0, num_under = 0;
  const Image surface = draw_volume(scene);
  const Image alone = draw_plane(scene);
  const Image image = draw(scene).image;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const auto place = place_on_plane(scene, x, y);
      ASSERT_TRUE(place);
      const double at = depth(surface, x, y);
      if (!(at < kInfinity) || std::abs(at - place->depth) < 1.5) continue;
      const double seen = depth(image, x, y);
      if (at < place->depth) {
        ASSERT_EQ(seen, at);
        ++num_over;
      } else if (pixel(alone, x, y).a() > 0) {
        ASSERT_NEAR(seen, place->depth, 1e-4);
        ++num_under;
      }
    }
  }
  EXPECT_GT(num_over, 20);
  EXPECT_GT(num_under, 20);
}

// Fails if what the field lacks on the plane is drawn, or hides what is behind it.
TEST(ValuePlane, HolesAreSeenThrough) {
  PlaneScene scene = linear_scene(0.1);
  scene.field = make_field(kDims, [](auto i, auto j, auto k) {
    const bool is_hole = j >= 3 && j <= 8 && k >= 4 && k <= 11 && i >= 4 && i <= 8;
    return is_hole ? kMissing : 0.5;
  });
  scene.camera = parallel_camera({6.5, 5.5, 7.5}, {1, 0, 0}, 9);
  scene.plane = plane_through({-1, 0, 0}, {6, 0, 0});
  const Image alone = draw_plane(scene);
  EXPECT_EQ(center_pixel(alone).a(), 0);
  EXPECT_EQ(pixel(alone, kWidth / 2, kHeight / 2 + 14).a(), 1);
  const double behind = center_pixel(draw(scene).image).a();
  EXPECT_NEAR(behind, center_pixel(draw_volume(scene, -1)).a(), 1e-6);
  EXPECT_GT(behind, 0.2);
  scene.plane.front = PlaneFront::kShown;
  EXPECT_NEAR(center_pixel(draw(scene).image).a(), center_pixel(draw_volume(scene)).a(), 1e-6);
  // Neither half reaches a half by itself.
  scene.look = gray_look(-0.2, 1.4, 0.1);
  ASSERT_LT(center_pixel(draw_volume(scene, 1)).a(), 0.5);
  ASSERT_LT(behind, 0.5);
  const Image whole = draw_volume(scene), image = draw(scene).image;
  EXPECT_EQ(center_front_depth(image), center_front_depth(whole));
  EXPECT_EQ(center_depth(image), center_depth(whole));
}

// Fails if the plane goes beyond a clip plane, or ends before it.
TEST(ValuePlane, ClipPlanesCutThePlane) {
  PlaneScene scene = linear_scene();
  const Image whole = draw(scene).image;
  scene.options.clip_planes = {{{0.2, 1, 0.3}, 8}, {{0, 0, -2}, -21}};
  const Image cut = draw(scene).image;
  int num_kept = 0, num_cut = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (pixel(whole, x, y).a() == 0) continue;
      const auto place = place_on_plane(scene, x, y);
      bool is_kept = true;
      for (const ClipPlane& plane : scene.options.clip_planes)
        is_kept = is_kept && plane.normal.dot(place->at) >= plane.offset;
      ASSERT_EQ(pixel(cut, x, y).a(), is_kept ? 1 : 0) << x << ", " << y;
      // The grid of texels is another one.
      if (is_kept) {
        ASSERT_NEAR(pixel(cut, x, y).r(), pixel(whole, x, y).r(), 2e-3);
      }
      ++(is_kept ? num_kept : num_cut);
    }
  }
  EXPECT_GT(num_kept, 50);
  EXPECT_GT(num_cut, 50);
}

// Where a pixel's limits do not reach the plane it is not seen; a pixel's coverage is that of all
// that is seen in it.
TEST(ValuePlane, DepthLimitsCutThePlane) {
  PlaneScene scene = linear_scene();
  const Image whole = draw(scene).image;
  auto limits = std::make_shared<DepthLimits>();
  limits->width = kWidth;
  limits->height = kHeight;
  limits->first.push_back(0);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const auto place = place_on_plane(scene, x, y);
      const float depth = place ? static_cast<float>(place->depth) : 1.0F;
      // Before the plane, around it, behind it.
      const float begin = depth + static_cast<float>(x % 3 - 1) * 2 - 0.5F;
      limits->stops.push_back({begin, true, {}});
      limits->stops.push_back({begin + 1, false, {}});
      limits->first.push_back(static_cast<std::uint32_t>(limits->stops.size()));
      limits->coverage.push_back(y % 2 == 0 ? 1.0F : 0.25F);
    }
  }
  scene.options.depth_limits = limits;
  scene.look = without_opacity(scene.look);
  const Image cut = draw(scene).image;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double share = x % 3 == 1 ? (y % 2 == 0 ? 1 : 0.25) : 0;
      ASSERT_NEAR(pixel(cut, x, y).a(), share * pixel(whole, x, y).a(), 1e-6) << x << ", " << y;
      ASSERT_NEAR(pixel(cut, x, y).r(), share * pixel(whole, x, y).r(), 1e-6);
    }
  }
}

// Fails if a plane that no ray meets changes anything, or half a volume is lost to it.
TEST(ValuePlane, EdgeOnAndBehindTheEyeIsNoPlane) {
  PlaneScene scene = linear_scene(0.2);
  const Vec3 middle(6.5, 5.5, 7.5);
  const auto expect_plain = [&] {
    for (const PlaneFront front : {PlaneFront::kShown, PlaneFront::kRemoved}) {
      scene.plane.front = front;
      EXPECT_EQ(draw(scene).image, draw_volume(scene));
    }
  };
  scene.camera = parallel_camera(middle, {0, 0, 1}, 9);
  scene.plane = plane_through({3, 1, 0}, middle);
  expect_plain();
  scene.camera = perspective_camera(middle, {0, 0, 1}, 9, 30);
  scene.plane = plane_through({3, 1, 0}, middle);  // through the eye
  expect_plain();
  scene.plane = plane_through({0, 0.1, 1}, {0, 0, -40});  // behind it
  expect_plain();
}

// Nearly edge-on, and from within the volume: fails if something is not finite.
TEST(ValuePlane, SlantedPlanesAreFinite) {
  PlaneScene scene = linear_scene(0.2);
  const Vec3 middle(6.5, 5.5, 7.5);
  for (const double tilt : {1e-9, 1e-5, 1e-3, 0.03}) {
    for (const double distance : {30.0, 2.0}) {
      for (const bool is_parallel : {true, false}) {
        scene.camera = perspective_camera(middle, {0, 0, 1}, 9, distance);
        scene.camera.parallel_projection = is_parallel;
        scene.camera.parallel_scale = 9;
        for (const PlaneFront front : {PlaneFront::kShown, PlaneFront::kRemoved}) {
          scene.plane = plane_through({1, tilt, tilt}, middle - Vec3(0.3, 0, 0));
          scene.plane.front = front;
          const Image image = draw(scene).image;
          for (const float x : image.rgba) ASSERT_TRUE(std::isfinite(x) && x >= 0 && x <= 1.0001F);
          for (const float z : image.depth) ASSERT_FALSE(std::isnan(z));
        }
      }
    }
  }
}

// Fails if a plane beside the volume hides it, or is not seen to have all of it on one side.
TEST(ValuePlane, BesideTheVolume) {
  PlaneScene scene = linear_scene(0.2);
  scene.camera = parallel_camera({6.5, 5.5, 7.5}, {1, 0, 0}, 9);
  const Image plain = draw_volume(scene);
  scene.plane = plane_through({1, 0, 0}, {-3, 0, 0});
  EXPECT_EQ(draw(scene).image, draw_volume(scene, 1));
  scene.plane = plane_through({1, 0, 0}, {20, 0, 0});
  const Image removed = draw(scene).image;
  EXPECT_TRUE(
      std::all_of(removed.rgba.begin(), removed.rgba.end(), [](float x) { return x == 0; }));
  scene.plane.front = PlaneFront::kShown;
  EXPECT_EQ(draw(scene).image, plain);
}

// Fails if a message does not name what is wrong.
TEST(ValuePlane, Errors) {
  const PlaneScene good = linear_scene();
  const auto refuse = [&](const std::function<void(PlaneScene&)>& change,
                          const std::string& start) {
    PlaneScene scene = good;
    change(scene);
    return code_of([&] { draw(scene); }, start);
  };
  constexpr ErrorCode kInvalid = ErrorCode::kInvalidArgument;
  EXPECT_EQ(refuse([](auto& s) { s.plane.normal = {0, 0, 0}; }, "plane.normal: must be"), kInvalid);
  EXPECT_EQ(refuse([](auto& s) { s.plane.normal.x() = kNan; }, "plane.normal: must be"), kInvalid);
  EXPECT_EQ(refuse([](auto& s) { s.plane.offset = kInfinity; }, "plane.offset = inf"), kInvalid);
  EXPECT_EQ(refuse([](auto& s) { s.options.clip_planes.resize(16); },
                   "clip_planes: 16 given, at most 15"),
            kInvalid);
  EXPECT_EQ(refuse([](auto& s) { s.options.width = 0; }, "width = 0"), kInvalid);
  for (const Mode mode : {Mode::kXray, Mode::kMaximum, Mode::kMean})
    EXPECT_EQ(refuse([&](auto& s) { s.look.mode = mode; }, "value plane: is for the modes"),
              ErrorCode::kUnsupported);
  PlaneScene most = good;
  most.options.clip_planes.resize(15, {{1, 0, 0}, -100});
  draw(most);
}

// Fails if progress falls or does not end at 1, or a stop is not heard in one of the parts.
TEST(ValuePlane, ProgressAndStop) {
  PlaneScene scene = linear_scene(0.1);
  for (const PlaneFront front : {PlaneFront::kShown, PlaneFront::kRemoved}) {
    scene.plane.front = front;
    std::vector<double> fractions;
    int num_done = 0;
    RenderHooks hooks;
    hooks.progress = [&](double fraction) { fractions.push_back(fraction); };
    hooks.tile_done = [&](const TileDone& tile) {
      ++num_done;
      EXPECT_EQ(tile.x1 * tile.y1, kWidth * kHeight);
    };
    draw(scene, 3, hooks);
    EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
    EXPECT_EQ(fractions.back(), 1.0);
    EXPECT_EQ(num_done, 1);
    for (const double at : {0.0, 0.05, 0.3, 0.7}) {
      std::stop_source source;
      RenderHooks stopping;
      stopping.stop = source.get_token();
      stopping.progress = [&](double fraction) {
        if (fraction >= at) source.request_stop();
      };
      EXPECT_EQ(code_of([&] { draw(scene, 1, stopping); }), ErrorCode::kCancelled) << at;
    }
  }
}

// Fails if who draws a row or a tile can be seen, or counts are those of one part alone.
TEST(ValuePlane, AnyNumberOfThreads) {
  for (const PlaneFront front : {PlaneFront::kShown, PlaneFront::kRemoved}) {
    PlaneScene scene = linear_scene(0.1);
    scene.plane.front = front;
    const Frame one = draw(scene, 1);
    EXPECT_EQ(draw(scene, 3).image, one.image);
    EXPECT_EQ(one.profile.backend, "cpu");
    EXPECT_EQ(one.profile.kernels_total, num_samples(kDims));
    EXPECT_GT(one.profile.samples_reconstructed, kWidth * kHeight / 8);
  }
}

// The reference draws the same, up to float rounding. Fails if the picture of values depends on
// what only one back end does.
TEST(ValuePlane, ReferenceAgrees) {
  PlaneScene scene = linear_scene(0.1);
  scene.plane.front = PlaneFront::kShown;
  scene.options = picture(36, 30);
  for (const Camera& camera : {cameras()[0], cameras()[1]}) {
    scene.camera = camera;
    Scene with_plane(scene.field, scene.look);
    with_plane.plane = scene.plane;
    Renderer reference(Backend::kReference, 2);
    const Image expected = reference.render(with_plane, scene.camera, scene.options).image;
    EXPECT_TRUE(agree(draw(scene).image, expected, "value_plane"));
  }
}

}  // namespace value_plane_test
}  // namespace ovoid::value_plane_test
