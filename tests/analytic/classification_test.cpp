// SPDX-License-Identifier: Apache-2.0
// Pieces between sheets and opacity by gradient against closed forms, on a field that rises
// straight along the ray: there the sum over sheets is an integral over values.
#include <gtest/gtest.h>

#include <cmath>

#include "ovoid/renderer.h"
#include "support/scenes.h"
#include "support/tolerances.h"
#include "support/volumes.h"

namespace ovoid::test {
namespace classification_test {

constexpr double kSlope = 2.0;

// f = kSlope z at the samples, and in between but for the kernels' ripple.
LatticeField ramp() {
  return make_field({12, 12, 24}, [](std::int64_t, std::int64_t, std::int64_t k) {
    return kSlope * static_cast<double>(k);
  });
}

// A peak of triangular opacity, narrower than two sheets are apart.
Look peak() {
  Look look;
  look.shade = false;
  look.unit_distance = 1;
  look.transfer_function.colors = {{0, {0, 0, 0}}, {46, {1, 1, 1}}};
  look.transfer_function.opacities = {{20.4, 0}, {20.8, 0.9}, {21.2, 0}};
  return look;
}

// Extinction over values: the integral of -ln(1 - A) over the peak is
// 2 * 0.4 / 0.9 * integral of -ln(1 - y) over [0, 0.9] = 0.8 / 0.9 * (0.9 + 0.1 ln 0.1).
double optical_depth() { return 0.8 / 0.9 * (0.9 + 0.1 * std::log(0.1)) / kSlope; }

double opacity_drawn(Backend backend, Classification classification, double sampling_distance,
                     double shift) {
  RenderOptions options = picture(3, 3, sampling_distance);
  options.classification = classification;
  const Vec3 focal_point(5.5, 5.5, 11.5 + shift);
  const Camera camera = parallel_camera(focal_point, {0, 0, 1}, 1);
  return center_pixel(Renderer(backend, 1).render({ramp(), peak()}, camera, options).image).a();
}

// Wherever the sheets lie, the whole peak is seen. The reconstructed ramp's ripple moves a piece's
// ends by at most 0.014 of a spacing's rise, and with it a share of what lies between them.
TEST(Preintegrated, SeesAPeakBetweenSheets) {
  const double expected = 1 - std::exp(-optical_depth());
  for (const Backend backend : {Backend::kReference, Backend::kCpu}) {
    for (const double distance : {0.5, 1.0, 2.0}) {
      for (const double shift : {0.0, 0.13, 0.31, 0.47}) {
        EXPECT_NEAR(opacity_drawn(backend, Classification::kPreintegrated, distance, shift),
                    expected, 0.02)
            << "distance " << distance << ", shift " << shift;
      }
    }
  }
}

// What it is for: samples alone meet the peak or miss it.
TEST(Preintegrated, IsNeededToSeeIt) {
  double least = 1;
  double greatest = 0;
  for (const double shift : {0.0, 0.13, 0.31, 0.47, 0.6, 0.8}) {
    const double opacity = opacity_drawn(Backend::kCpu, Classification::kSampled, 1.0, shift);
    least = std::min(least, opacity);
    greatest = std::max(greatest, opacity);
  }
  EXPECT_LT(least, 0.05);
  EXPECT_GT(greatest, 0.5);
}

// Along a ramp the gradient is kSlope: opacity A G, over the path.
TEST(GradientOpacity, IsAFactorPerUnitDistance) {
  for (const Backend backend : {Backend::kReference, Backend::kCpu}) {
    for (const double factor : {0.0, 0.25, 1.0}) {
      Look look = uniform_look(0.2);
      look.unit_distance = 1;
      look.transfer_function.gradient_opacities = {{0, 0}, {kSlope, factor}, {10, factor}};
      // Within 4 spacings around the middle, where nothing of the border is seen.
      RenderOptions options = picture(3, 3, 0.5);
      options.clip_planes = {{{0, 0, 1}, 9.5}, {{0, 0, -1}, -13.5}};
      const Camera camera = parallel_camera({5.5, 5.5, 11.5}, {0, 0, 1}, 1);
      const Image image = Renderer(backend, 1).render({ramp(), look}, camera, options).image;
      // The kernels are cut off, which takes kCutOffShare of the slope; here it is a factor.
      EXPECT_NEAR(center_pixel(image).a(), 1 - std::pow(1 - 0.2 * factor, 4.0), kCutOffShare)
          << factor;
    }
  }
}

// Along a ramp the gradient is kSlope, half-way between two rows of the table: their mean.
TEST(Look2D, IsReadAtTheGradientPerWorldLength) {
  for (const Backend backend : {Backend::kReference, Backend::kCpu}) {
    for (const Classification how : {Classification::kSampled, Classification::kRefined}) {
      Look look = uniform_look(1);
      look.unit_distance = 1;
      const TransferFunction2D::Rgba low{0, 0.25F, 1, 0.1F}, high{1, 0.75F, 0, 0.3F};
      look.transfer_function_2d =
          TransferFunction2D({-10, 60, 2}, {kSlope - 1, kSlope + 1, 2}, {low, low, high, high});
      RenderOptions options = picture(3, 3, 0.5);
      options.classification = how;
      options.clip_planes = {{{0, 0, 1}, 9.5}, {{0, 0, -1}, -13.5}};
      const Camera camera = parallel_camera({5.5, 5.5, 11.5}, {0, 0, 1}, 1);
      const auto pixel =
          center_pixel(Renderer(backend, 1).render({ramp(), look}, camera, options).image);
      const double alpha = 1 - std::pow(1 - 0.2, 4.0);
      // The slope ripples by kCutOffShare, over which colours change by half of that.
      EXPECT_NEAR(pixel.a(), alpha, kCutOffShare);
      EXPECT_NEAR(pixel.r() / pixel.a(), 0.5, kCutOffShare);
      EXPECT_NEAR(pixel.g() / pixel.a(), 0.5, kCutOffShare);
    }
  }
}

// Flat regions fade away altogether, and with them their light.
TEST(GradientOpacity, HidesWhatIsFlat) {
  Look look = uniform_look(0.5);
  look.transfer_function.gradient_opacities = {{0.1, 0}, {0.2, 1}};
  for (const Backend backend : {Backend::kReference, Backend::kCpu}) {
    const Image image = Renderer(backend, 1)
                            .render({constant_field({8, 8, 8}, 3), look},
                                    parallel_camera({3.5, 3.5, 3.5}, {0, 0, 1}, 2), picture(4, 4))
                            .image;
    for (const float component : image.rgba) EXPECT_EQ(component, 0.0F);
  }
}

}  // namespace classification_test
}  // namespace ovoid::test
