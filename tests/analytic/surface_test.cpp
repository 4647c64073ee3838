// SPDX-License-Identifier: Apache-2.0
// Isosurfaces: where they are, how they are lit, what cuts them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "ovoid/renderer.h"
#include "render/reference/field_evaluator.h"
#include "render/reference/reference_renderer.h"
#include "support/scenes.h"
#include "support/tolerances.h"
#include "support/volumes.h"

namespace ovoid::test {
namespace surface_test {

using reference::render;

Look surface_look(double iso) {
  Look look = gray_look(0, 1);
  look.mode = Mode::kIsosurface;
  look.isovalue = iso;
  return look;
}

double along_z(std::int64_t, std::int64_t, std::int64_t k) { return static_cast<double>(k); }

// The field of the samples value = k along z, by its definition on one axis: at z, or over the slab
// of `thickness` around it.
double ramp_at(double z, double thickness) {
  double n = 0;
  double d = 0;
  const double half = 0.5 * thickness;
  for (auto k = static_cast<int>(std::ceil(z - half - 2)); k <= z + half + 2; ++k) {
    const double from = std::max(z - half - k, -2.0);
    const double to = std::min(z + half - k, 2.0);
    const double g = thickness > 0
                         ? std::erf(std::numbers::sqrt2 * to) - std::erf(std::numbers::sqrt2 * from)
                         : std::exp(-2 * (z - k) * (z - k));
    n += k * g;
    d += g;
  }
  return n / d;
}

double ramp_crossing(double iso, double thickness = 0) {
  double lo = iso - 0.5;
  double hi = iso + 0.5;
  for (int step = 0; step < 60; ++step) {
    const double middle = 0.5 * (lo + hi);
    (ramp_at(middle, thickness) < iso ? lo : hi) = middle;
  }
  return lo;
}

// A ramp's surfaces are planes at mu^-1(iso). After 8 bisections of a slab the secant step errs by
// (ds / 256)^2 / 8 times f'' / f', which is below 6 there: 1e-5 of a unit for ds = 1. Fails if the
// refinement stops early or takes the wrong half.
TEST(Isosurface, DepthOfAPlane) {
  const LatticeField ramp = make_field({8, 8, 16}, along_z);
  const Camera camera = parallel_camera({3.5, 3.5, 7.5}, {0, 0, 1}, 1);
  for (const double iso : {3.3, 6.0, 7.4, 10.9}) {
    for (const double ds : {1.0, 0.4}) {
      for (const Slab slab : {Slab::kMid, Slab::kMean}) {
        const Image image = render(ramp, camera, surface_look(iso), picture(3, 3, ds, slab)).image;
        EXPECT_NEAR(center_depth(image), 92.5 + ramp_crossing(iso, slab == Slab::kMean ? ds : 0),
                    2e-5)
            << iso << " " << ds;
        EXPECT_EQ(center_pixel(image).a(), 1);
      }
    }
  }
}

// Distance r from a middle. The field is off by the normal times the three axes' |mu(t) - t| <=
// 0.0226 (sigma^2 times the slope of the sum's ripple, 4 pi exp(-pi^2 / 2)), 0.0226 sqrt 3 = 0.039,
// and by half the Laplacian 2 / r times the kernels' variance <= 0.286, 0.029. So the sphere of iso
// 10 lies within 0.07 of radius 10, everywhere.
TEST(Isosurface, RadiusOfABall) {
  const double middle = 13.3;
  const auto distance = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return Vec3(static_cast<double>(i) - middle, static_cast<double>(j) - middle,
                static_cast<double>(k) - middle)
        .norm();
  };
  const LatticeField field = make_field({28, 28, 28}, distance);
  const Vec3 direction = Vec3(1, -0.6, 0.8).normalized();
  const double half_height = 9.9;
  const Camera camera = parallel_camera(Vec3::Constant(middle), direction, half_height);
  const RenderOptions options = picture(40, 40, 1);
  const Image image = render(field, camera, surface_look(10), options).image;
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 40; ++x) {
      const double across = (2 * (x + 0.5) / 40 - 1) * half_height;
      const double up = (1 - 2 * (y + 0.5) / 40) * half_height;
      const double r2 = across * across + up * up;
      if (r2 > 9.7 * 9.7) continue;  // beyond, a sheet's step may pass through the rim
      const double z = depth(image, x, y) - 100;
      ASSERT_NEAR(std::sqrt(r2 + z * z), 10, 0.07) << x << " " << y;
      ASSERT_LT(z, 0) << "the far side was taken";
    }
  }
}

// Crossings count downwards as well, and the first one wins.
TEST(Isosurface, FirstCrossingEitherWay) {
  const auto ridge = [](std::int64_t, std::int64_t, std::int64_t k) {
    return 8.0 - std::abs(static_cast<double>(k) - 8);
  };
  const LatticeField field = make_field({8, 8, 17}, ridge);
  const Image up =
      render(field, parallel_camera({3.5, 3.5, 8}, {0, 0, 1}, 1), surface_look(4.0), picture(3, 3))
          .image;
  EXPECT_NEAR(center_depth(up), 92 + 4, 1e-4);
  RenderOptions from_inside = picture(3, 3);
  from_inside.clip_planes = {{{0, 0, 1}, 6.0}};
  const Image down =
      render(field, parallel_camera({3.5, 3.5, 8}, {0, 0, 1}, 1), surface_look(4.0), from_inside)
          .image;
  EXPECT_NEAR(center_depth(down), 92 + 12, 1e-4);
}

// A plane just behind the surface cuts it away; just before it, leaves it.
TEST(Isosurface, CrossingBehindAClipPlaneIsPassedOver) {
  const LatticeField ramp = make_field({8, 8, 16}, along_z);
  const Camera camera = parallel_camera({3.5, 3.5, 7.5}, {0, 0, 1}, 1);
  RenderOptions options = picture(3, 3);
  options.clip_planes = {{{0, 0, 1}, ramp_crossing(7.4) + 1e-3}};
  EXPECT_EQ(center_pixel(render(ramp, camera, surface_look(7.4), options).image).a(), 0);
  options.clip_planes = {{{0, 0, 1}, ramp_crossing(7.4) - 1e-3}};
  EXPECT_EQ(center_pixel(render(ramp, camera, surface_look(7.4), options).image).a(), 1);
}

// An isovalue that no sample straddles, one met only beyond the volume's face, and one across a
// hole.
TEST(Isosurface, NothingWhereTheFieldIsUndefined) {
  const Camera camera = parallel_camera({3.5, 3.5, 7.5}, {0, 0, 1}, 1);
  const LatticeField ramp = make_field({8, 8, 16}, along_z);
  for (const double iso : {-0.5, 15.5, 100.0}) {
    EXPECT_EQ(center_pixel(render(ramp, camera, surface_look(iso), picture(3, 3)).image).a(), 0)
        << iso;
  }
  const auto torn = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    return k >= 6 && k <= 9 ? kMissing : along_z(i, j, k);
  };
  EXPECT_EQ(
      center_pixel(
          render(make_field({8, 8, 16}, torn), camera, surface_look(7.5), picture(3, 3)).image)
          .a(),
      0);
}

// Outer surfaces that are seen through show inner ones, each in its own colour, in the order of the
// ray, whichever way the value goes; on both back ends. Fails if a surface's opacity, colour or
// order is another's, or if the depth is that of what is hardly seen.
TEST(Isosurface, SeveralAreSeenThroughEachOther) {
  const LatticeField ramp = make_field({8, 8, 16}, along_z);
  Look look = surface_look(0);
  look.isosurfaces = {{9.6, Rgb{0, 0, 1}, 1}, {4.3, Rgb{1, 0, 0}, 0.25}, {4.7, Rgb{0, 1, 0}, 0.4}};
  Renderer cpu(Backend::kCpu, 1);
  for (const double sign : {1.0, -1.0}) {
    const Camera camera = parallel_camera({3.5, 3.5, 7.5}, {0, 0, sign}, 1);
    for (const Image& image : {render(ramp, camera, look, picture(3, 3, 1)).image,
                               cpu.render({ramp, look}, camera, picture(3, 3, 1)).image}) {
      const Pixel at = center_pixel(image);
      if (sign > 0) {
        EXPECT_NEAR(at.r(), 0.25, kFloatRelative);
        EXPECT_NEAR(at.g(), 0.75 * 0.4, kFloatRelative);
        EXPECT_NEAR(at.b(), 0.75 * 0.6, kFloatRelative);
        // 0.25 and 0.55: the second brings it over a half.
        EXPECT_NEAR(center_depth(image), 92.5 + ramp_crossing(4.7), 1e-3);
        EXPECT_NEAR(center_front_depth(image), 92.5 + ramp_crossing(4.3), 1e-3);
      } else {
        EXPECT_NEAR(at.b(), 1, kFloatRelative);
        EXPECT_NEAR(at.r() + at.g(), 0, kFloatRelative);
        EXPECT_NEAR(center_depth(image), 107.5 - ramp_crossing(9.6), 1e-3);
      }
      EXPECT_EQ(at.a(), 1);
    }
  }
  // Between two sheets the lesser first where the value rises, the greater first where it falls.
  look.isosurfaces.erase(look.isosurfaces.begin());
  const Camera backwards = parallel_camera({3.5, 3.5, 7.5}, {0, 0, -1}, 1);
  for (const Image& image : {render(ramp, backwards, look, picture(3, 3, 1)).image,
                             cpu.render({ramp, look}, backwards, picture(3, 3, 1)).image}) {
    EXPECT_NEAR(center_pixel(image).g(), 0.4, kFloatRelative);
    EXPECT_NEAR(center_pixel(image).r(), 0.6 * 0.25, kFloatRelative);
    EXPECT_NEAR(center_pixel(image).a(), 1 - 0.6 * 0.75, kFloatRelative);
    EXPECT_NEAR(center_depth(image), 107.5 - ramp_crossing(4.3), 1e-3);
  }
  // Without a colour of its own a surface has the look's.
  look.isosurfaces = {{8.0, {}, 0.5}};
  look.transfer_function.colors = {{0, {0, 0, 0}}, {16, {1, 1, 1}}};
  EXPECT_NEAR(center_pixel(cpu.render({ramp, look}, backwards, picture(3, 3)).image).r(), 0.25,
              1e-6);
}

// Lit like everything else: colour of the isovalue, headlight, the surface's slant.
TEST(Isosurface, IsLitByItsGradient) {
  const auto slanted = [](std::int64_t i, std::int64_t, std::int64_t k) {
    return static_cast<double>(k) + 0.75 * static_cast<double>(i);
  };
  const LatticeField field = make_field({17, 8, 17}, slanted);
  Look look = surface_look(14);
  look.transfer_function.colors = {{0, {0.2, 0.5, 0.8}}, {30, {0.2, 0.5, 0.8}}};
  look.shade = true;
  const Camera camera = parallel_camera({8, 3.5, 8}, {0, 0, 1}, 1);
  const Image image = render(field, camera, look, picture(3, 3)).image;
  // At the crossing the normal is the field's own gradient there.
  const reference::FieldEvaluator evaluator(field);
  const Vec3 normal = evaluator.at_world({8, 3.5, center_depth(image) - 92}).gradient.normalized();
  EXPECT_NEAR(normal.z(), 0.8, 0.1);
  const double specular = 0.2 * std::pow(normal.z(), 10);
  EXPECT_NEAR(center_pixel(image).r(), 0.2 * (0.1 + 0.7 * normal.z()) + specular, 1e-4);
  EXPECT_NEAR(center_pixel(image).b(), 0.8 * (0.1 + 0.7 * normal.z()) + specular, 1e-4);
}

}  // namespace surface_test
}  // namespace ovoid::test
