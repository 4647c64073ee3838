// SPDX-License-Identifier: Apache-2.0
// Fails if a pick tells another place than the picture shows, or another field than the one that is
// there: by spheres and ramps whose places, values and gradients are known.
#include "ovoid/pick.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>

#include "ovoid/error.h"
#include "ovoid/model.h"
#include "ovoid/renderer.h"
#include "support/scenes.h"
#include "support/volumes.h"

namespace ovoid::test {
namespace pick_test {

constexpr int kSide = 33;

// What a picture is of, and the picture.
struct PickedScene {
  Field field;
  Camera camera;
  Look look;
  RenderOptions options = picture(kSide, kSide);
  Backend backend = Backend::kCpu;

  Pick at(int x, int y) const {
    const FieldProbe probe(field);
    Renderer renderer(backend, 1);
    const Frame frame = renderer.render({field, look}, camera, options);
    return pick(frame.image, x, y, {field, probe, camera, look, options});
  }
};

const Vec3 kMiddle{20, 20, 20};

// 3 |x - middle|^2 / 400, of which B-splines make that and a constant; spheres around the middle.
double squared_distance(const Vec3& place) { return (place - kMiddle).squaredNorm() * 3 / 400; }

LatticeField spheres() {
  return make_field({41, 41, 41},
                    [](std::int64_t i, std::int64_t j, std::int64_t k) {
                      return squared_distance(Vec3(static_cast<double>(i), static_cast<double>(j),
                                                   static_cast<double>(k)));
                    },
                    {.kernel = kBSplineKernel});
}

// Along x, 0 to 24.
LatticeField ramp_along_x() {
  return make_field({25, 9, 9}, [](std::int64_t i, std::int64_t, std::int64_t) {
    return static_cast<double>(i);
  });
}

const Vec3 kOblique = Vec3(1, 0.3, -0.4).normalized();

Camera camera_of(bool is_parallel, double half_height = 15) {
  return is_parallel ? parallel_camera(kMiddle, kOblique, half_height)
                     : perspective_camera(kMiddle, kOblique, half_height, 90);
}

// The middle pixel and one beside it, by either camera: fails if rays are half a pixel off, upside
// down, or if depths are taken for distances.
TEST(Pick, FindsASphereInBothProjections) {
  for (const bool is_parallel : {true, false}) {
    PickedScene scene{spheres(), camera_of(is_parallel), {}};
    scene.look = with_mode(gray_look(0, 3), Mode::kIsosurface);
    scene.look.isovalue = 1.0;
    const Vec3 right = kOblique.cross(scene.camera.view_up).normalized();
    const Vec3 up = right.cross(kOblique);
    for (const auto& [x, y] : {std::pair{16, 16}, {22, 12}, {9, 20}}) {
      const Pick found = scene.at(x, y);
      ASSERT_TRUE(found.place) << x << ' ' << y;
      const Pick::Place& place = *found.place;
      EXPECT_NEAR(place.sample.value, 1.0, 2e-3);
      EXPECT_NEAR((place.position - kMiddle).norm(), std::sqrt(400.0 / 3), 0.1);
      // A pixel is 30 / 33 wide where the camera looks.
      const Vec3 aside = (x - 16) * 30.0 / kSide * right - (y - 16) * 30.0 / kSide * up;
      const Vec3 offset = place.position - scene.camera.position;
      EXPECT_NEAR(offset.dot(kOblique), place.depth, 1e-9);
      const double distance = (scene.camera.focal_point - scene.camera.position).norm();
      const Vec3 expected =
          place.depth * kOblique + aside * (is_parallel ? 1.0 : place.depth / distance);
      EXPECT_LT((offset - expected).norm(), 1e-9) << is_parallel;
      const Vec3 slope = 6.0 / 400 * (place.position - kMiddle);
      EXPECT_LT((place.sample.gradient - slope).norm(), 0.05 * slope.norm());
      EXPECT_NEAR(place.direction.norm(), 1, 1e-12);
      EXPECT_GT(place.direction.dot(kOblique), 0.9);
      EXPECT_TRUE(place.index->isApprox(place.position));  // this lattice's own
      EXPECT_EQ(found.opacity, 1);
    }
    EXPECT_FALSE(scene.at(0, 0).place);
    EXPECT_EQ(scene.at(0, 0).opacity, 0);
  }
}

// Opaque beyond a value: within a sheet of it, on either back end that has no device.
TEST(Pick, FindsWhereOpacityReachesAHalf) {
  for (const Backend backend : {Backend::kCpu, Backend::kReference}) {
    PickedScene scene{ramp_along_x(), parallel_camera({12, 4, 4}, {1, 0, 0}, 3), uniform_look(1)};
    scene.backend = backend;
    scene.look.transfer_function.opacities = {{0, 0}, {10, 0}, {10, 0.9}, {30, 0.9}};
    const Pick found = scene.at(16, 16);
    ASSERT_TRUE(found.place);
    EXPECT_NEAR(found.place->position.x(), 10, 0.5);  // half a spacing from sheet to sheet
    EXPECT_NEAR(found.place->position.y(), 4, 1e-9);
    EXPECT_NEAR(found.place->sample.value, found.place->position.x(), 1e-3);
    EXPECT_NEAR(found.place->sample.gradient.x(), 1, 0.2);
  }
}

// A look too faint for a half: fails if the nearest place that is seen is told instead.
TEST(Pick, FindsTheGreatestShareOfWhatIsSeenThrough) {
  PickedScene scene{ramp_along_x(), parallel_camera({12, 4, 4}, {1, 0, 0}, 3), uniform_look(1)};
  scene.look.unit_distance = 1;
  scene.look.transfer_function.opacities = {
      {0, 0.004}, {14, 0.004}, {15, 0.2}, {16, 0.004}, {24, 0.004}};
  const Pick found = scene.at(16, 16);
  ASSERT_TRUE(found.place);
  EXPECT_LT(found.opacity, 0.5);
  EXPECT_NEAR(found.place->position.x(), 15, 0.5);
  // Clipped away, the rest adds most where it begins: what is nearer hides.
  scene.options.clip_planes = {{{1, 0, 0}, 17}};
  EXPECT_NEAR(scene.at(16, 16).place->position.x(), 17, 1);
}

TEST(Pick, FindsTheNearestOfFaintSurfaces) {
  PickedScene scene{ramp_along_x(), parallel_camera({12, 4, 4}, {1, 0, 0}, 3), gray_look(0, 24)};
  scene.look.mode = Mode::kIsosurface;
  scene.look.isosurfaces = {{8, {}, 0.2}, {14, {}, 0.3}};
  const Pick found = scene.at(16, 16);
  ASSERT_TRUE(found.place);
  EXPECT_NEAR(found.opacity, 1 - 0.8 * 0.7, 1e-6);
  EXPECT_NEAR(found.place->position.x(), 8, 0.05);
  scene.look.isosurfaces[1].opacity = 1;  // brings it over a half
  EXPECT_NEAR(scene.at(16, 16).place->position.x(), 14, 0.05);
}

TEST(Pick, FindsTheGreatestAndTheMeansGreatestShare) {
  PickedScene scene{make_field({25, 9, 9},
                               [](std::int64_t i, std::int64_t, std::int64_t) {
                                 const double x = static_cast<double>(i);
                                 return 5 - 0.1 * (x - 18) * (x - 18) / 4;
                               }),
                    parallel_camera({12, 4, 4}, {1, 0, 0}, 3), gray_look(0, 6)};
  for (const Mode mode : {Mode::kMaximum, Mode::kMean, Mode::kXray}) {
    scene.look.mode = mode;
    const Pick found = scene.at(16, 16);
    ASSERT_TRUE(found.place) << static_cast<int>(mode);
    EXPECT_NEAR(found.place->position.x(), 18, 1.01);
    EXPECT_EQ(found.integral.has_value(), mode == Mode::kXray);
  }
  scene.look.mode = Mode::kXray;
  EXPECT_GT(*scene.at(16, 16).integral, 24 * 1.0);  // never under 1 along 25
}

// Half a ball cut away: the cut is picked where it is opaque, nothing where all is gone.
TEST(Pick, SeesWhatClipPlanesLeave) {
  PickedScene scene{spheres(), camera_of(true), uniform_look(1)};
  scene.look.transfer_function.opacities = {{0, 1}, {1, 1}, {1, 0}, {4, 0}};
  scene.options.clip_planes = {{kOblique, kOblique.dot(kMiddle) + 2}};
  const Pick cut = scene.at(16, 16);
  ASSERT_TRUE(cut.place);
  EXPECT_NEAR((cut.place->position - kMiddle).dot(kOblique), 2, 0.5);
  scene.options.clip_planes = {{-kOblique, -kOblique.dot(kMiddle) + 13}};
  EXPECT_FALSE(scene.at(16, 16).place);
}

TEST(Pick, OfKernelsHasNoIndex) {
  const Field field = make_kernel_field(make_sample("blobs", {}), {});
  PickedScene scene{field, default_camera(field.world_bounds()), ramp_look(field.value_range())};
  const Pick found = scene.at(16, 16);
  ASSERT_TRUE(found.place);
  EXPECT_TRUE(found.place->sample.is_defined);
  EXPECT_FALSE(found.place->index);
  const FieldProbe probe(field);
  EXPECT_EQ(probe.at(found.place->position).value, found.place->sample.value);
}

// Sheets closer than anybody waits for do not make a pick wait.
TEST(Pick, TakesPixelsOfThePictureAlone) {
  PickedScene scene{ramp_along_x(), parallel_camera({12, 4, 4}, {1, 0, 0}, 3),
                    gray_look(0, 24, 0.01)};
  const FieldProbe probe(scene.field);
  Renderer renderer(Backend::kCpu, 1);
  const Frame frame = renderer.render({scene.field, scene.look}, scene.camera, scene.options);
  scene.options.sampling_distance = 1e-9;
  const auto asked = [&](int x, int y) {
    return pick(frame.image, x, y, {scene.field, probe, scene.camera, scene.look, scene.options});
  };
  EXPECT_TRUE(asked(16, 16).place);
  for (const auto& [x, y] : {std::pair{-1, 0}, {0, -1}, {kSide, 0}, {0, kSide}}) {
    try {
      asked(x, y);
      ADD_FAILURE() << x << ' ' << y;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
      EXPECT_NE(std::string(error.what()).find("outside of the picture, expected 0,0 to 32,32"),
                std::string::npos)
          << error.what();
    }
  }
}

}  // namespace pick_test
}  // namespace ovoid::test
