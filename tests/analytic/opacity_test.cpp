// SPDX-License-Identifier: Apache-2.0
// A homogeneous box absorbs 1 - (1 - A)^(L / unit), however it is cut into sheets and pixels.
#include <gtest/gtest.h>

#include <cmath>

#include "ovoid/error.h"
#include "render/reference/reference_renderer.h"
#include "support/scenes.h"
#include "support/tolerances.h"
#include "support/volumes.h"

namespace ovoid::test {
namespace opacity_test {

using reference::render;

double law(double opacity, double length, double unit = 1) {
  return 1 - std::pow(1 - opacity, length / unit);
}

// The box of 8 cells around (3.5, 3.5, 3.5), seen along z: 8 long.
constexpr double kOpacity = 0.21;
const Vec3 kHazeMiddle(3.5, 3.5, 3.5);
LatticeField box() { return constant_field({8, 8, 8}, 0.5); }
Camera haze_camera() { return parallel_camera(kHazeMiddle, {0, 0, 1}, 4); }

// Distances that divide half the box, so that slabs end on its faces. Fails if path, unit or the
// count of sheets is off by anything.
TEST(Opacity, OfABoxDoesNotDependOnTheSamplingDistance) {
  for (const Slab slab : {Slab::kMid, Slab::kMean}) {
    for (const double ds : {4.0, 2.0, 1.0, 0.5, 0.125}) {
      const Image image =
          render(box(), haze_camera(), uniform_look(kOpacity), picture(5, 5, ds, slab)).image;
      EXPECT_NEAR(center_pixel(image).a(), law(kOpacity, 8), kFloatRelative) << ds;
    }
  }
}

TEST(Opacity, IsPerUnitDistance) {
  for (const double unit : {0.5, 1.0, 3.7}) {
    Look look = uniform_look(kOpacity);
    look.unit_distance = unit;
    const Image image = render(box(), haze_camera(), look, picture(5, 5)).image;
    EXPECT_NEAR(center_pixel(image).a(), law(kOpacity, 8, unit), kFloatRelative) << unit;
  }
  // Unit by the transfer function, then by the field's smallest spacing.
  Look look = uniform_look(kOpacity);
  look.unit_distance = 0;
  EXPECT_NEAR(center_pixel(render(box(), haze_camera(), look, picture(5, 5, 0.5)).image).a(),
              law(kOpacity, 8), kFloatRelative);
  look.transfer_function.unit_distance = 2.0;
  EXPECT_NEAR(center_pixel(render(box(), haze_camera(), look, picture(5, 5, 0.5)).image).a(),
              law(kOpacity, 8, 2), kFloatRelative);
}

// Odd sizes have the same middle ray; up to pixels of two spacings, where kernels are twice as
// wide.
TEST(Opacity, OfABoxDoesNotDependOnTheResolution) {
  for (const int side : {5, 9, 25, 61}) {
    const Image image =
        render(box(), haze_camera(), uniform_look(kOpacity), picture(side, side)).image;
    EXPECT_NEAR(center_pixel(image).a(), law(kOpacity, 8), kFloatRelative) << side;
    // Every ray that is two pixels or spacings inside the box is as long.
    for (int x = 0; x < side; ++x) {
      const double u = 3.5 + (2 * (x + 0.5) / side - 1) * 4;
      if (std::abs(u - 3.5) < 2) {
        EXPECT_NEAR(pixel(image, x, side / 2).a(), law(kOpacity, 8), kFloatRelative);
      }
    }
  }
}

TEST(Opacity, ColourIsPremultiplied) {
  const Image image =
      render(box(), haze_camera(), uniform_look(kOpacity, {0.25, 0.5, 1}), picture(5, 5)).image;
  const double alpha = law(kOpacity, 8);
  EXPECT_NEAR(center_pixel(image).r(), 0.25 * alpha, kFloatRelative);
  EXPECT_NEAR(center_pixel(image).g(), 0.5 * alpha, kFloatRelative);
  EXPECT_NEAR(center_pixel(image).b(), alpha, kFloatRelative);
}

// World units count, not spacings: oblique axes, along the third of them, which is perpendicular to
// nothing.
TEST(Opacity, OfAnObliqueBox) {
  FieldSetup setup;
  setup.world_from_index = oblique_axes();
  const LatticeField field = constant_field({9, 9, 10}, 0.5, setup);
  const Vec3 axis = oblique_axes().linear().col(2);
  const double length = 10 * axis.norm();
  const Camera camera = parallel_camera(oblique_axes() * Vec3(4, 4, 4.5), axis, 3);
  for (const double part : {1.0, 0.5, 0.25}) {
    const RenderOptions options = picture(9, 9, axis.norm() * part);
    const Image image = render(field, camera, uniform_look(0.1), options).image;
    EXPECT_NEAR(center_pixel(image).a(), law(0.1, length), kFloatRelative) << part;
  }
}

// A slanted ray's length is cut into whole slabs: at most one slab too many or too few, less the
// finer they are. The faces lie kFaceMargin further out than the cells'.
TEST(Opacity, OfASlantedBoxConverges) {
  constexpr double kFaceMargin = 0.02;
  const Vec3 direction = Vec3(1, 0, 2).normalized();
  const double length = 8 / direction.z();
  const Camera camera = parallel_camera(kHazeMiddle, direction, 4);
  for (const double ds : {1.0, 0.3, 0.1, 0.01}) {
    const Image image = render(box(), camera, uniform_look(kOpacity), picture(9, 9, ds)).image;
    EXPECT_GE(center_pixel(image).a(), law(kOpacity, length - ds));
    EXPECT_LE(center_pixel(image).a(),
              law(kOpacity, length + 2 * kFaceMargin / direction.z() + ds));
  }
}

// In perspective a ray beside the axis is longer by the length of its direction.
TEST(Opacity, OfABoxInPerspective) {
  const LatticeField slabs = constant_field({40, 40, 8}, 0.5);
  const Vec3 middle(19.5, 19.5, 3.5);
  const Camera camera = perspective_camera(middle, {0, 0, 1}, 9, 20);
  const RenderOptions options = picture(31, 21, 0.5);
  const Image image = render(slabs, camera, uniform_look(0.05), options).image;
  for (int y = 0; y < options.height; ++y) {
    for (int x = 0; x < options.width; ++x) {
      const double right = (2 * (x + 0.5) / 31 - 1) * 31 / 21.0 * 9 / 20;
      const double up = (1 - 2 * (y + 0.5) / 21) * 9 / 20;
      const double stretch = std::sqrt(1 + right * right + up * up);
      ASSERT_NEAR(pixel(image, x, y).a(), law(0.05, 8 * stretch), kFloatRelative) << x << " " << y;
    }
  }
}

// A plane anywhere leaves the exact length: sheets are shortened, not dropped.
TEST(Opacity, OfAClippedBox) {
  for (const Slab slab : {Slab::kMid, Slab::kMean}) {
    for (const double cut : {3.5, 3.62, 0.01, -0.3, 7.499}) {
      RenderOptions options = picture(5, 5, 1, slab);
      options.clip_planes = {{{0, 0, 2}, 2 * cut}};  // keeps z >= cut, whatever the normal's length
      const Image behind = render(box(), haze_camera(), uniform_look(kOpacity), options).image;
      EXPECT_NEAR(center_pixel(behind).a(), law(kOpacity, 7.5 - cut), kFloatRelative) << cut;
      options.clip_planes = {{{0, 0, -1}, -cut}};
      const Image before = render(box(), haze_camera(), uniform_look(kOpacity), options).image;
      EXPECT_NEAR(center_pixel(before).a(), law(kOpacity, cut + 0.5), kFloatRelative) << cut;
    }
  }
}

// Two planes cut on both sides of one slab, slanted ones along the ray, and planes beside it all or
// nothing.
TEST(Opacity, OfSeveralClipPlanes) {
  RenderOptions options = picture(5, 5, 1);
  options.clip_planes = {{{0, 0, 1}, 3.1}, {{0, 0, -1}, -3.4}};
  const Look look = uniform_look(kOpacity);
  EXPECT_NEAR(center_pixel(render(box(), haze_camera(), look, options).image).a(),
              law(kOpacity, 0.3), kFloatRelative);
  options.clip_planes = {{{1, 0, 1}, 3.5 + 2.25}};  // meets the middle ray at z = 2.25
  EXPECT_NEAR(center_pixel(render(box(), haze_camera(), look, options).image).a(),
              law(kOpacity, 7.5 - 2.25), kFloatRelative);
  options.clip_planes = {{{1, 0, 0}, 3.6}};
  EXPECT_EQ(center_pixel(render(box(), haze_camera(), look, options).image).a(), 0);
  options.clip_planes = {{{1, 0, 0}, 3.4}};
  EXPECT_NEAR(center_pixel(render(box(), haze_camera(), look, options).image).a(), law(kOpacity, 8),
              kFloatRelative);
  options.clip_planes = {{{0, 0, 1}, 3.5}, {{0, 0, -1}, -3.4}};
  EXPECT_EQ(center_pixel(render(box(), haze_camera(), look, options).image).a(), 0);
}

// The near plane is half a sampling distance before the camera. A camera inside sees from there on,
// exactly, if a slab whose sheet exists reaches across it: of 4.13, each of the distances leaves
// 0.13 before the first such slab.
TEST(Opacity, OfABoxAroundTheCamera) {
  for (const double ds : {1.0, 0.5, 0.4}) {
    Camera camera = perspective_camera({3.5, 3.5, 7.5}, {0, 0, 1}, 2, 4.13);
    const Image image = render(box(), camera, uniform_look(kOpacity), picture(5, 5, ds)).image;
    EXPECT_NEAR(center_pixel(image).a(), law(kOpacity, 4.13 - ds / 2), kFloatRelative) << ds;
    camera.parallel_projection = true;  // has no near plane
    camera.parallel_scale = 2;
    const Image both = render(box(), camera, uniform_look(kOpacity), picture(5, 5, ds)).image;
    EXPECT_NEAR(center_pixel(both).a(), law(kOpacity, 8), kFloatRelative) << ds;
  }
}

// No sample is taken once a pixel has 1 - 1/1024, and the one that brings it there is taken whole.
// Depth is where it has a half. The first refined piece is the half from the face to the first
// sheet, and samples of pieces lie in their middles.
TEST(Opacity, StopsWhereItIsOpaque) {
  const LatticeField deep = constant_field({8, 8, 64}, 0.5);
  const Camera camera = parallel_camera({3.5, 3.5, 31.5}, {0, 0, 1}, 4);
  for (const Classification classification : {Classification::kSampled, Classification::kRefined}) {
    const bool is_refined = classification == Classification::kRefined;
    for (const double opacity : {0.13, 0.5, 0.9}) {
      double transparency = 1;
      double depth = 0;
      int samples = 0;
      while (1 - transparency < 1 - 1.0 / 1024) {
        const bool is_half = is_refined && samples == 0;
        const double before = transparency;
        transparency *= std::pow(1 - opacity, is_half ? 0.5 : 1.0);
        if (transparency <= 0.5 + 1e-9 && before > 0.5 + 1e-9)
          depth = 100 - 31.5 + samples - (is_half ? 0.25 : is_refined ? 0.5 : 0.0);
        ++samples;
      }
      RenderOptions options = picture(1, 1, 1);
      options.classification = classification;
      const Frame frame = render(deep, camera, uniform_look(opacity), options, {}, 1);
      EXPECT_EQ(frame.profile.samples_shaded, samples);
      EXPECT_NEAR(center_pixel(frame.image).a(), 1 - transparency, kFloatRelative) << opacity;
      EXPECT_NEAR(center_depth(frame.image), depth, 100 * kFloatRelative) << opacity;
    }
  }
  const Image faint = render(box(), haze_camera(), uniform_look(0.05), picture(5, 5)).image;
  EXPECT_TRUE(std::isinf(center_depth(faint)));
}

// Fails if the front depth is that of another opacity than 1/255, of another sample than the one
// that reaches it, or of a haze that never does.
TEST(Opacity, IsSeenFromWhereItShows) {
  const LatticeField deep = constant_field({8, 8, 64}, 0.5);
  const Camera camera = parallel_camera({3.5, 3.5, 31.5}, {0, 0, 1}, 4);
  constexpr double kFirst = 100 - 31.5;
  for (const double opacity : {0.00393, 0.0015, 0.0001, 0.00005}) {
    // Samples that it takes; refined, the first is the half from the face to the first sheet.
    const double whole = std::log(1 - 1.0 / 255) / std::log(1 - opacity);
    for (const bool is_refined : {false, true}) {
      RenderOptions options = picture(1, 1, 1);
      options.classification = is_refined ? Classification::kRefined : Classification::kSampled;
      const Image image = render(deep, camera, uniform_look(opacity), options, {}, 1).image;
      if (whole > 64) {
        EXPECT_TRUE(std::isinf(center_front_depth(image))) << opacity;
        continue;
      }
      const double before = is_refined ? std::ceil(whole - 0.5) - 0.5 : std::ceil(whole) - 1;
      EXPECT_NEAR(center_front_depth(image), kFirst + before, 100 * kFloatRelative) << opacity;
      EXPECT_TRUE(std::isinf(center_depth(image))) << opacity;
    }
  }
  const Image clear = render(deep, camera, uniform_look(0.5), picture(1, 1, 1), {}, 1).image;
  EXPECT_NEAR(center_front_depth(clear), kFirst - 0.25, 100 * kFloatRelative);
}

// Fails if a pixel goes on beyond the opacity that is asked for, or stops before it.
TEST(Opacity, StopsWhereItIsToldTo) {
  const LatticeField deep = constant_field({8, 8, 64}, 0.5);
  const Camera camera = parallel_camera({3.5, 3.5, 31.5}, {0, 0, 1}, 4);
  for (const Classification classification : {Classification::kSampled, Classification::kRefined}) {
    double before = 0;
    for (const double opaque_at : {0.3, 0.9, 1 - 1e-4, 1.0}) {
      RenderOptions options = picture(1, 1, 1);
      options.classification = classification;
      options.opaque_at = opaque_at;
      const double alpha = center_pixel(render(deep, camera, uniform_look(0.2), options).image).a();
      EXPECT_GT(alpha, before);
      if (opaque_at < 1) {
        EXPECT_GE(alpha, opaque_at - kFloatRelative);
        EXPECT_LT(1 - alpha, (1 - opaque_at) * 1.0001);
        EXPECT_GT((1 - alpha) / 0.79, 1 - opaque_at) << "one sample more than it takes";
      }
      before = alpha;
    }
  }
  for (const double wrong : {0.0, -1.0, 1.5, std::nan("")}) {
    RenderOptions options;
    options.opaque_at = wrong;
    EXPECT_THROW(options.validate(), Error);
  }
}

}  // namespace opacity_test
}  // namespace ovoid::test
