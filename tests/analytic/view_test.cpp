// SPDX-License-Identifier: Apache-2.0
// Cameras against each other, thin volumes, and the frame as a whole: threads, hooks, bad
// arguments.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "ovoid/error.h"
#include "ovoid/model.h"
#include "render/reference/reference_renderer.h"
#include "support/compare.h"
#include "support/scenes.h"
#include "support/tolerances.h"
#include "support/volumes.h"

namespace ovoid::test {
namespace view_test {

using reference::render;

double viewed_bumps(std::int64_t i, std::int64_t j, std::int64_t k) {
  return 0.5 +
         0.3 * std::sin(0.9 * static_cast<double>(i)) * std::cos(0.7 * static_cast<double>(j)) +
         0.2 * std::sin(0.5 * static_cast<double>(k));
}

LatticeField bumps() {
  FieldSetup setup;
  setup.world_from_index = oblique_axes();
  return make_field({12, 10, 9}, viewed_bumps, setup);
}

Look colourful() {
  Look look;
  look.transfer_function.colors = {
      {0, {0.1, 0.2, 0.9}}, {0.5, {0.9, 0.9, 0.3}}, {1, {0.9, 0.1, 0.1}}};
  look.transfer_function.opacities = {{0.2, 0}, {0.9, 0.6}};
  look.unit_distance = 1;
  return look;
}

const Vec3 kMiddle = oblique_axes() * Vec3(5.5, 4.5, 4);

// From 1e7 away rays converge by 1e-6 of the volume's size: the same picture, up to that times
// slopes of colours (a few), and pixels whose first or last sheet is just inside for one of them
// (5e-7 / 0.8 of the pixels each).
TEST(View, PerspectiveFromFarIsParallel) {
  const Vec3 direction(0.4, -0.3, 1);
  const RenderOptions options = picture(24, 20);
  const Image parallel =
      render(bumps(), parallel_camera(kMiddle, direction, 9, 1e7), colourful(), options).image;
  const Image perspective =
      render(bumps(), perspective_camera(kMiddle, direction, 9, 1e7), colourful(), options).image;
  const ImageDifference difference = compare(perspective, parallel);
  EXPECT_LT(difference.max_float, 1e-4) << difference.to_string();
  EXPECT_GT(difference.num_covered, 100);
}

// Moving volume and camera together moves nothing; at map coordinates of 1e6 doubles leave 1e-10
// spacings.
TEST(View, DoesNotDependOnTheOrigin) {
  FieldSetup setup;
  setup.world_from_index = Eigen::Translation3d(5e5, 4e6, -300) * oblique_axes();
  const LatticeField moved = make_field({12, 10, 9}, viewed_bumps, setup);
  const Vec3 direction(0.4, -0.3, 1);
  const Image here =
      render(bumps(), perspective_camera(kMiddle, direction, 9, 40), colourful(), picture(24, 20))
          .image;
  const Image there =
      render(moved, perspective_camera(kMiddle + Vec3(5e5, 4e6, -300), direction, 9, 40),
             colourful(), picture(24, 20))
          .image;
  EXPECT_LT(compare(there, here).max_float, 1e-5);
}

// The middle of a picture is the picture of the middle: the same rays at another size and aspect.
TEST(View, RaysDependOnPositionOnly) {
  const Camera camera = perspective_camera(kMiddle, {1, 0.2, -0.4}, 6, 30);
  const Image wide = render(bumps(), camera, colourful(), picture(30, 20)).image;
  const Image square = render(bumps(), camera, colourful(), picture(20, 20)).image;
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 20; ++x) {
      ASSERT_NEAR(pixel(wide, x + 5, y).r(), pixel(square, x, y).r(), 1e-6);
      ASSERT_NEAR(pixel(wide, x + 5, y).a(), pixel(square, x, y).a(), 1e-6);
    }
  }
}

// Minified far below a pixel, a single slice and a whole volume are still seen.
TEST(View, ThinVolumesDoNotVanish) {
  const Look look = uniform_look(1);
  const Camera near = parallel_camera({15.5, 15.5, 0}, {0, 0, 1}, 10);
  const Camera far = parallel_camera({15.5, 15.5, 0}, {0, 0, 1}, 64);
  const LatticeField slice = constant_field({32, 32, 1}, 1);
  EXPECT_EQ(center_pixel(render(slice, near, look, picture(33, 33)).image).a(), 1);
  EXPECT_EQ(center_pixel(render(slice, far, look, picture(33, 33)).image).a(), 1);
  const LatticeField volume = constant_field({8, 8, 8}, 1);
  for (const double half_height : {4.0, 40.0, 400.0}) {
    const Camera camera = parallel_camera({3.5, 3.5, 3.5}, {0, 0, 1}, half_height);
    EXPECT_EQ(center_pixel(render(volume, camera, look, picture(5, 5)).image).a(), 1)
        << half_height;
  }
}

// A lattice of odd size has sheets on its faces; all their pixels are on one side. Samples stand
// for half a sheet beyond the faces, too; pieces end there.
TEST(View, SheetsOnAFaceAreWhole) {
  const Camera camera = parallel_camera({10, 10, 4}, {0, 0, 1}, 7);
  for (const bool is_refined : {false, true}) {
    for (const Slab slab : {Slab::kMid, Slab::kMean}) {
      RenderOptions options = picture(16, 16, 1, slab);
      options.classification = is_refined ? Classification::kRefined : Classification::kSampled;
      const Image image =
          render(constant_field({21, 21, 9}, 1), camera, uniform_look(0.1), options).image;
      const double expected = 1 - std::pow(0.9, is_refined ? 9 : 10);
      for (int y = 0; y < 16; ++y) {
        for (int x = 0; x < 16; ++x)
          ASSERT_NEAR(pixel(image, x, y).a(), expected, kFloatRelative) << x << " " << y;
      }
    }
  }
}

TEST(View, NothingBehindTheCameraOrBesideTheVolume) {
  const Camera away = perspective_camera(kMiddle + Vec3(0, 0, 60), {0, 0, 1}, 9, 20);
  const Image image = render(bumps(), away, colourful(), picture(8, 8)).image;
  for (const float number : image.rgba) EXPECT_EQ(number, 0);
  for (const float z : image.depth) EXPECT_TRUE(std::isinf(z));
}

// ---- The frame
// -------------------------------------------------------------------------------------------------------

const Camera kCamera = perspective_camera(kMiddle, {0.4, -0.3, 1}, 9, 40);

TEST(Frame, SameBytesForAnyNumberOfThreads) {
  const Image one = render(bumps(), kCamera, colourful(), picture(23, 17), {}, 1).image;
  EXPECT_EQ(render(bumps(), kCamera, colourful(), picture(23, 17), {}, 3).image, one);
  EXPECT_EQ(render(bumps(), kCamera, colourful(), picture(23, 17), {}, 64).image, one);
  EXPECT_EQ(render(bumps(), kCamera, colourful(), picture(23, 17)).image, one);
}

// A source in memory and one by bricks give the same bytes.
TEST(Frame, SameBytesForAnySource) {
  const Index3 dims{12, 10, 9};
  std::vector<float> samples;
  for (int k = 0; k < 9; ++k) {
    for (int j = 0; j < 10; ++j) {
      for (int i = 0; i < 12; ++i) samples.push_back(static_cast<float>(viewed_bumps(i, j, k)));
    }
  }
  Dataset dataset;
  dataset.lattice = {dims, oblique_axes()};
  dataset.arrays.push_back({"a",
                            ScalarType::kFloat32,
                            1,
                            num_samples(dims),
                            "",
                            false,
                            {nullptr, std::as_bytes(std::span(samples))}});
  LatticeModelOptions published;
  published.kernel = LatticeKernel{};
  const LatticeField same = make_lattice_field(dataset, published);
  const Image resident = render(same, kCamera, colourful(), picture(23, 17)).image;
  EXPECT_EQ(render(bumps(), kCamera, colourful(), picture(23, 17)).image, resident);
  FieldSetup setup;
  setup.world_from_index = oblique_axes();
  setup.brick_edge = 4;
  EXPECT_EQ(
      render(make_field(dims, viewed_bumps, setup), kCamera, colourful(), picture(23, 17)).image,
      resident);
}

TEST(Frame, ProgressAndTilesAreReported) {
  std::vector<double> fractions;
  std::vector<int> rows(17, 0);
  RenderHooks hooks;
  hooks.progress = [&](double fraction) { fractions.push_back(fraction); };
  hooks.tile_done = [&](const TileDone& tile) {
    EXPECT_EQ(tile.x0, 0);
    EXPECT_EQ(tile.x1, 23);
    EXPECT_EQ(tile.image->width, 23);
    for (int y = tile.y0; y < tile.y1; ++y) ++rows[static_cast<std::size_t>(y)];
  };
  const Frame frame = render(bumps(), kCamera, colourful(), picture(23, 17), hooks, 2);
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_EQ(fractions.back(), 1.0);
  EXPECT_EQ(rows, std::vector<int>(17, 1));
  EXPECT_EQ(frame.profile.backend, "reference");
  EXPECT_EQ(frame.profile.threads, 2);
  EXPECT_EQ(frame.profile.kernels_total, 12 * 10 * 9);
  EXPECT_GT(frame.profile.samples_reconstructed, frame.profile.samples_shaded);
  EXPECT_GT(frame.profile.samples_shaded, 0);
}

ErrorCode code_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.code();
  }
  throw std::logic_error("no ovoid::Error was thrown");
}

TEST(Frame, StopsWhenAsked) {
  std::stop_source stop;
  RenderHooks hooks;
  hooks.stop = stop.get_token();
  int rows = 0;
  hooks.tile_done = [&](const TileDone&) {
    if (++rows == 3) stop.request_stop();
  };
  EXPECT_EQ(code_of([&] { render(bumps(), kCamera, colourful(), picture(23, 40), hooks, 2); }),
            ErrorCode::kCancelled);
  EXPECT_LT(rows, 10);
}

// What a hook throws arrives at the caller, and no thread is left behind.
TEST(Frame, ExceptionsOfHooksArrive) {
  RenderHooks hooks;
  hooks.progress = [](double) { throw std::runtime_error("enough"); };
  EXPECT_THROW(render(bumps(), kCamera, colourful(), picture(23, 40), hooks, 2),
               std::runtime_error);
}

TEST(Frame, RefusesBadArguments) {
  const auto refused = [](const LatticeField& field, const Camera& camera, const Look& look,
                          const RenderOptions& options, int threads) {
    return code_of([&] { render(field, camera, look, options, {}, threads); }) ==
           ErrorCode::kInvalidArgument;
  };
  EXPECT_TRUE(refused(LatticeField{}, kCamera, colourful(), {}, 1));
  EXPECT_TRUE(refused(bumps(), kCamera, colourful(), {}, -1));
  EXPECT_TRUE(refused(bumps(), kCamera, colourful(), picture(0, 5), 1));
  EXPECT_TRUE(refused(bumps(), kCamera, colourful(), picture(5, 5, 1e-12), 1));
  Camera camera = kCamera;
  camera.position = camera.focal_point;
  EXPECT_TRUE(refused(bumps(), camera, colourful(), {}, 1));
  Look look = colourful();
  look.material.specular_power = 0;
  EXPECT_TRUE(refused(bumps(), kCamera, look, {}, 1));
}

}  // namespace view_test
}  // namespace ovoid::test
