// SPDX-License-Identifier: Apache-2.0
// The values and colours of a plane, against analytic fields and the sampler.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "ovoid/sampler.h"
#include "render/passes/test_plane_frame.h"
#include "support/kernel_sets.h"

namespace ovoid::value_plane_test {
namespace plane_values_test {

// Normalized weights bring the mean of the samples' places nearer to the samples by up to
// 4 pi sigma^2 exp(-2 pi^2 sigma^2) = 0.0226 spacings along each axis (docs/numerics.md, "Grid
// patterns"); cut-off and interpolation between texels are a tenth of that.
constexpr double kPlaceError = 0.025;

// Fails if values are those of another place, if the picture of values is mirrored, turned or
// shifted by half a texel, or if depth is along the ray.
TEST(PlaneValues, LinearFieldHasItsColors) {
  PlaneScene scene = linear_scene();
  const double bound = kPlaceError * kSlope.lpNorm<1>() / 1.6;
  for (const Camera& camera : cameras()) {
    for (const ValuePlane& plane : planes()) {
      scene.camera = camera;
      scene.plane = plane;
      const Image image = draw(scene).image;
      int num_inside = 0;
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          const auto place = place_on_plane(scene, x, y);
          if (!place) continue;
          const Pixel pixel = test::pixel(image, x, y);
          // How far inside of the outermost samples, spacings. The field ends half a spacing
          // beyond them, earlier along edges, where two faces take from the weights.
          const Vec3 last(13, 11, 15);
          const Vec3 within = place->at.cwiseMin(last - place->at);
          const double inside = within.minCoeff();
          if (inside < -0.532) {
            ASSERT_EQ(pixel.a(), 0) << x << ", " << y;
          } else if (inside > -0.5 && (within.array() < 1.5).count() < 2) {
            ASSERT_EQ(pixel.a(), 1) << x << ", " << y;
            ASSERT_NEAR(depth(image, x, y), place->depth, 1e-5 * place->depth);
            if (inside < 2.5) continue;  // two texels and more from where the field bends
            const double gray = (0.5 + kSlope.dot(place->at) + 0.2) / 1.6;
            ASSERT_NEAR(pixel.r(), gray, bound) << x << ", " << y;
            ++num_inside;
          }
        }
      }
      EXPECT_GT(num_inside, 30);
    }
  }
}

// Two pixels and more inside of what the plane covers.
bool is_well_inside(const Image& image, int x, int y) {
  for (int j = std::max(0, y - 2); j <= std::min(image.height - 1, y + 2); ++j) {
    for (int i = std::max(0, x - 2); i <= std::min(image.width - 1, x + 2); ++i) {
      if (pixel(image, i, j).a() == 0) return false;
    }
  }
  return true;
}

// The greatest difference of the red channel to a function of what a sampler says of the places.
double greatest_difference(const PlaneScene& scene, const Image& image,
                           const std::function<double(const FieldSample&)>& red, int* count) {
  const FieldSampler sampler(scene.field);
  double greatest = 0;
  *count = 0;
  for (int y = 0; y < scene.options.height; ++y) {
    for (int x = 0; x < scene.options.width; ++x) {
      const auto place = place_on_plane(scene, x, y);
      const Pixel pixel = test::pixel(image, x, y);
      if (!place || !is_well_inside(image, x, y)) continue;
      const FieldSample at = sampler.at(place->at);
      greatest = std::max(greatest, std::abs(pixel.r() - red(at)));
      ++*count;
    }
  }
  return greatest;
}

// Curves through four texels, half of a pixel of 0.37 spacings apart: of one isolated sample they
// lose less than 0.6 % of its peak, of these waves no more. Fails if a texel is wider than that, or
// values are read by the nearest one (a tenth) or along straight lines (2 %).
TEST(PlaneValues, ValuesAreTheFieldsOwn) {
  PlaneScene scene = linear_scene();
  scene.field = make_field(kDims, [](auto i, auto j, auto k) {
    return 0.5 + 0.5 * std::sin(1.1 * static_cast<double>(i)) *
                     std::cos(0.9 * static_cast<double>(j) - 0.7 * static_cast<double>(k));
  });
  scene.look = gray_look(0, 1, 0);
  for (const Camera& camera : cameras()) {
    scene.camera = camera;
    int count = 0;
    const double greatest = greatest_difference(
        scene, draw(scene).image, [](const FieldSample& at) { return at.value; }, &count);
    EXPECT_LT(greatest, 0.006);
    EXPECT_GT(count, 300);
  }
}

// A plane seen squarely has its texels on the pixels: floats' rounding alone. Fails if the grid of
// texels is shifted.
TEST(PlaneValues, SquarelySeenIsExact) {
  PlaneScene scene = linear_scene();
  scene.camera = parallel_camera({6.5, 5.5, 7.5}, {1, 2, -0.5}, 9);
  scene.field = make_field(kDims, [](auto i, auto j, auto k) {
    return static_cast<double>((i * 7 + j * 5 + k * 3) % 11) * 0.1;
  });
  scene.look = gray_look(0, 1, 0);
  int count = 0;
  EXPECT_LT(greatest_difference(
                scene, draw(scene).image, [](const FieldSample& at) { return at.value; }, &count),
            1e-5);
  EXPECT_GT(count, 500);
}

// Fails if colours are mixed between texels, or end values, steps and colours beyond the ends are
// not the transfer function's.
TEST(PlaneValues, ColorsAreTheTransferFunctions) {
  PlaneScene scene = linear_scene();
  TransferFunction& tf = scene.look.transfer_function;
  tf.colors = {{0.3, {0, 1, 0}}, {0.5, {1, 0, 0}}, {0.7, {0, 0, 1}}};
  tf.color_space = ColorSpace::kStep;
  tf.below_color = Rgb{1, 1, 0};
  tf.above_color = Rgb{0, 1, 1};
  const Image image = draw_plane(scene);
  const FieldSampler sampler(scene.field);
  int num_known = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const auto place = place_on_plane(scene, x, y);
      const Pixel pixel = test::pixel(image, x, y);
      if (!place || pixel.a() == 0) continue;
      const FieldSample at = sampler.at(place->at);
      const Rgb lower = tf.color_at(at.value - 2e-3);
      if (!at.is_defined || lower != tf.color_at(at.value + 2e-3)) continue;
      ASSERT_EQ((Rgb{pixel.r(), pixel.g(), pixel.b()}), lower) << x << ", " << y;
      ++num_known;
    }
  }
  EXPECT_GT(num_known, 300);
}

// Fails if kernel sets are widened by the sheets of the picture of values, or their borders are
// elsewhere. Their texels are a pixel wide; kernels of 0.07 are six pixels.
TEST(PlaneValues, KernelSets) {
  PlaneScene scene = linear_scene();
  scene.look = gray_look(0, 1, 0);
  const Vec3 middle(0.5, 0.5, 0.5);
  for (const auto reconstruction : {Reconstruction::kNormalized, Reconstruction::kSum}) {
    scene.field = KernelField(jittered_balls(9).source(), reconstruction);
    for (const bool is_parallel : {true, false}) {
      scene.camera = perspective_camera(middle, {1, 0.4, 0.3}, 0.6, 4);
      scene.camera.parallel_projection = is_parallel;
      scene.camera.parallel_scale = 0.6;
      scene.plane = plane_through({2, -0.5, 1}, middle);
      int count = 0;
      EXPECT_LT(greatest_difference(
                    scene, draw(scene).image,
                    [](const FieldSample& at) { return std::clamp(at.value, 0.0, 1.0); }, &count),
                0.02);
      EXPECT_GT(count, 400);
    }
  }
}

// Fails if colour comes from the attribute of opacity, or loses digits along a logarithm.
TEST(PlaneValues, KernelSetsWithColorsOfTheirOwn) {
  PlaneScene scene = linear_scene();
  const Vec3 middle(0.5, 0.5, 0.5);
  KernelNumbers numbers = jittered_balls(9);
  std::vector<float> other(numbers.values[0].size());
  for (std::size_t i = 0; i < other.size(); ++i)
    other[i] = static_cast<float>(std::pow(10.0, 2 * numbers.centers[3 * i + 1] - 7));
  numbers.values = {numbers.values[0], other};
  scene.field = KernelField(numbers.source(), Reconstruction::kNormalized, 0, 1);
  scene.camera = perspective_camera(middle, {1, 0.4, 0.3}, 0.6, 4);
  scene.plane = plane_through({2, -0.5, 1}, middle);
  scene.look = gray_look(0, 1, 0.1);
  TransferFunction colors;
  colors.colors = {{1e-7, {0, 0, 0}}, {1e-5, {1, 1, 1}}};
  for (const ValueScale scale : {ValueScale::kLinear, ValueScale::kLog, ValueScale::kSymlog}) {
    colors.scale = scale;
    colors.linear_width = 1e-6;
    scene.look.color_function = colors;
    int count = 0;
    EXPECT_LT(
        greatest_difference(
            scene, draw_plane(scene),
            [&](const FieldSample& at) { return colors.color_at(at.color_value)[0]; }, &count),
        0.02);
    EXPECT_GT(count, 400);
  }
}

// Fails if a sum is cut off where its outermost samples are.
TEST(PlaneValues, SumsReachBeyondTheirSamples) {
  PlaneScene scene = linear_scene();
  FieldSetup setup;
  setup.reconstruction = Reconstruction::kSum;
  scene.field = linear_field(setup);
  scene.look = gray_look(0, 1.5, 0);
  int count = 0;
  EXPECT_LT(greatest_difference(
                scene, draw(scene).image,
                [](const FieldSample& at) { return std::clamp(at.value / 1.5, 0.0, 1.0); }, &count),
            0.02);
  int normalized = 0;
  scene.field = linear_field();
  greatest_difference(
      scene, draw(scene).image, [](const FieldSample& at) { return at.value; }, &normalized);
  EXPECT_GT(count, normalized * 1.2);
}

// A plane so slanted that pixels are several texels long, which are wide as pixels are where the
// plane is nearest. Stripes eight spacings apart, seen at two and more to the pixel, have the
// mean's gray but for what the ends of the pixel do: 1 / (2 pi) of their amplitude of 0.64. Fails
// if texels are skipped: stripes are 0 or 1.
TEST(PlaneValues, SlantedPlanesAreMeans) {
  PlaneScene scene = linear_scene();
  scene.field =
      make_field({24, 256, 4}, [](auto, auto j, auto) { return static_cast<double>(j / 4 % 2); });
  scene.look = gray_look(0, 1, 0);
  constexpr double kSine = 0.1;
  scene.camera = perspective_camera({12, 128, 1.5}, {0, 1, -kSine}, 70, 160);
  scene.plane = plane_through({0, 0, 1}, {0, 0, 1.5});
  const Image image = draw(scene).image;
  int num_long = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const auto place = place_on_plane(scene, x, y);
      if (!place || !is_well_inside(image, x, y)) continue;
      const double pitch = 2 * 70.0 / kHeight * place->depth / 160;
      if (pitch / kSine < 16) continue;
      ASSERT_NEAR(pixel(image, x, y).r(), 0.5, 0.2) << x << ", " << y;
      ++num_long;
    }
  }
  EXPECT_GT(num_long, 10);
}

}  // namespace plane_values_test
}  // namespace ovoid::value_plane_test
