// SPDX-License-Identifier: Apache-2.0
// Blinn-Phong on fields whose gradient is known. A ramp of slope 1 along n, opaque at its first
// sample, has N = +-n there.
#include <gtest/gtest.h>

#include <cmath>

#include "render/reference/reference_renderer.h"
#include "support/scenes.h"
#include "support/tolerances.h"
#include "support/volumes.h"

namespace ovoid::test {
namespace light_test {

using reference::render;

// Values grow along (1, 0, 2): gradients in its direction wherever both axes have the same phase,
// as in the cell middles and on the samples that the picture's middle ray meets.
LatticeField slanted_ramp() {
  return make_field({16, 16, 16}, [](std::int64_t i, std::int64_t, std::int64_t k) {
    return static_cast<double>(i - 8) + 2 * static_cast<double>(k - 8);
  });
}
const Vec3 kNormal = Vec3(1, 0, 2).normalized();

Look opaque_look() {
  Look look;
  look.transfer_function.colors = {{-30, {0.2, 0.5, 0.8}}, {30, {0.2, 0.5, 0.8}}};
  look.transfer_function.opacities = {{-30, 1}, {30, 1}};
  return look;
}

Vec3 shade_of(const LatticeField& field, const Look& look, const Camera& camera,
              GradientMethod gradient = GradientMethod::kExact) {
  RenderOptions options = picture(9, 9, 1);
  options.gradient = gradient;
  draw_from(97.25, options);  // away from the faces
  const Pixel at = center_pixel(render(field, camera, look, options).image);
  EXPECT_EQ(at.a(), 1);
  return {at.r(), at.g(), at.b()};
}

Vec3 blinn_phong(const Material& m, double n_l, double n_h, bool is_same_side) {
  const double specular = is_same_side ? m.specular * std::pow(std::abs(n_h), m.specular_power) : 0;
  return Vec3(0.2, 0.5, 0.8) * (m.ambient + m.diffuse * std::abs(n_l)) + Vec3::Constant(specular);
}

// The middle ray runs along z at x = y = 8, z on samples plus 1/2: focal point on a sample, sheets
// half-way. There the x axis has phase 0 and the z axis 1/2, and their slopes differ; so the camera
// is shifted to x = 8.5.
Camera front(double x = 8.5) { return parallel_camera({x, 8, 8}, {0, 0, 1}, 3); }

TEST(Light, Headlight) {
  const Look look = opaque_look();
  const double n_l = kNormal.z();
  const Vec3 expected = blinn_phong(look.material, n_l, n_l, true);
  EXPECT_NEAR((shade_of(slanted_ramp(), look, front()) - expected).norm(), 0, 1e-6);
  // Two-sided: from behind the same.
  const Camera behind = parallel_camera({8.5, 8, 8}, {0, 0, -1}, 3);
  EXPECT_NEAR((shade_of(slanted_ramp(), look, behind) - expected).norm(), 0, 1e-6);
}

TEST(Light, DirectionalFromAnywhere) {
  Look look = opaque_look();
  look.material = {0.15, 0.5, 0.4, 3.5};
  const Vec3 to_eye(0, 0, -1);
  for (const Vec3& light : {Vec3(0.3, 1, -2), Vec3(-1, 0.2, 0.1), Vec3(1, 1, 1), Vec3(0, 0, -7)}) {
    look.light_direction = light;
    const Vec3 l = light.normalized();
    const Vec3 h = (l + to_eye).normalized();
    const bool is_same_side = kNormal.dot(l) * kNormal.dot(to_eye) >= 0;
    const Vec3 expected = blinn_phong(look.material, kNormal.dot(l), kNormal.dot(h), is_same_side);
    EXPECT_NEAR((shade_of(slanted_ramp(), look, front()) - expected).norm(), 0, 1e-6)
        << light.transpose();
  }
  // The light exactly behind: no half vector.
  look.light_direction = Vec3(0, 0, 1);
  EXPECT_NEAR(
      (shade_of(slanted_ramp(), look, front()) - blinn_phong(look.material, kNormal.z(), 0, false))
          .norm(),
      0, 1e-6);
}

// The normal turned to the eye, three quarters of the key's light round the surface, and the fill.
TEST(Light, StudioHasAKeyAndAFill) {
  Look look = opaque_look();
  look.light = Light::kStudio;
  look.material = {0.15, 0.5, 0.4, 3.5};
  const Vec3 to_eye(0, 0, -1);
  const Vec3 seen = kNormal.dot(to_eye) < 0 ? Vec3(-kNormal) : kNormal;
  for (const Vec3& light : {Vec3(0.3, 1, -2), Vec3(-1, 0.2, 0.1), Vec3(1, 1, 1), Vec3(0, 0, -7)}) {
    look.light_direction = light;
    const Vec3 l = light.normalized();
    const double n_l = seen.dot(l);
    const double n_h = seen.dot((l + to_eye).normalized());
    const double diffuse =
        0.65 * std::max(0.0, (n_l + 0.25) / 1.25) + 0.35 * 0.5 * (1 + seen.dot(to_eye));
    const double specular = n_l > 0 ? 0.4 * std::pow(n_h, 3.5) : 0;
    const Vec3 expected = Vec3(0.2, 0.5, 0.8) * (0.15 + 0.5 * diffuse) + Vec3::Constant(specular);
    EXPECT_NEAR((shade_of(slanted_ramp(), look, front()) - expected).norm(), 0, 1e-6)
        << light.transpose();
  }
}

// Each adds to what the look's own light shows, from either side; where the field is flat, by half.
TEST(Light, FurtherLightsAdd) {
  Look look = opaque_look();
  look.material = {0.1, 0.3, 0.2, 3.5};
  const Vec3 color(0.2, 0.5, 0.8);
  const Vec3 to_eye(0, 0, -1);
  const LatticeField flat_field = constant_field({16, 16, 16}, 5);
  for (const Light kind : {Light::kSingle, Light::kStudio}) {
    look.light = kind;
    look.light_direction = Vec3(0.3, 1, -2);
    look.further_lights.clear();
    const Vec3 own = shade_of(slanted_ramp(), look, front());
    const Vec3 own_flat = shade_of(flat_field, look, front());
    look.further_lights = {{Vec3(-2, 0.4, 0.2), 0.8}, {Vec3(0, 0, -3), 0.3}};
    Vec3 expected = own;
    for (const FurtherLight& light : look.further_lights) {
      const Vec3 l = light.direction.normalized();
      const Vec3 h = (l + to_eye).normalized();
      const bool is_same_side = kNormal.dot(l) * kNormal.dot(to_eye) >= 0;
      const double shine = is_same_side ? std::pow(std::abs(kNormal.dot(h)), 3.5) : 0;
      expected +=
          light.intensity * (color * 0.3 * std::abs(kNormal.dot(l)) + Vec3::Constant(0.2 * shine));
    }
    EXPECT_LT(expected.maxCoeff(), 1);  // nothing is clamped
    EXPECT_NEAR((shade_of(slanted_ramp(), look, front()) - expected).norm(), 0, 1e-6);
    const Vec3 expected_flat = own_flat + color * 0.3 * 0.5 * (0.8 + 0.3);
    EXPECT_NEAR((shade_of(flat_field, look, front()) - expected_flat).norm(), 0, 1e-6);
  }
}

// Below it, light fades by how much the field rises.
TEST(Light, FlatRiseIsTheLooks) {
  Look look = opaque_look();
  look.light_direction = Vec3(1, 0, -0.2);
  const Vec3 lit = shade_of(slanted_ramp(), look, front());
  const Vec3 flat = Vec3(0.2, 0.5, 0.8) * 0.8;
  look.flat_rise = 1;  // 60 over a spacing: the ramp rises by its slope's length alone
  const Vec3 faded = shade_of(slanted_ramp(), look, front());
  const double q = (faded - flat).norm() / (lit - flat).norm();
  EXPECT_GT(q, 0.01);
  EXPECT_LT(q, 0.2);
  EXPECT_NEAR((faded - flat).normalized().dot((lit - flat).normalized()), 1, 1e-6);
}

// Each ray has its own eye vector in perspective.
TEST(Light, HeadlightInPerspective) {
  const Look look = opaque_look();
  const Camera camera = perspective_camera({8.5, 8.5, 8.5}, {0, 0, 1}, 6, 12);
  const RenderOptions options = picture(9, 9, 1);
  const LatticeField flat_on =
      make_field({16, 16, 16},
                 [](std::int64_t, std::int64_t, std::int64_t k) { return static_cast<double>(k); });
  const Image image = render(flat_on, camera, look, options).image;
  for (int x = 2; x < 7; ++x) {
    const double slope = (2 * (x + 0.5) / 9 - 1) * 0.5;
    const double cosine = 1 / std::sqrt(1 + slope * slope);
    const Vec3 expected = blinn_phong(look.material, cosine, cosine, true);
    EXPECT_NEAR(pixel(image, x, 4).r(), expected[0], 1e-6) << x;
    EXPECT_NEAR(pixel(image, x, 4).b(), expected[2], 1e-6) << x;
  }
}

TEST(Light, BrightColoursAreClamped) {
  Look look = opaque_look();
  look.material = {0.5, 0.9, 0.9, 1};
  EXPECT_EQ(shade_of(slanted_ramp(), look, front())[2], 1);
}

// Flat regions show ambient + diffuse: no noise of rounding becomes a normal. Between, the light
// fades in by q.
TEST(Light, FlatRegionsShowAmbientAndDiffuse) {
  Look look = opaque_look();
  const double ambient_diffuse = 0.1 + 0.7;
  const Vec3 flat = shade_of(constant_field({16, 16, 16}, 5), look, front());
  EXPECT_NEAR((flat - ambient_diffuse * Vec3(0.2, 0.5, 0.8)).norm(), 0, 1e-6);

  // Slope a with q = 1/4: a = 1/4 * 1e-4 * span, span = 60. The slope of a ramp's field at phase
  // 1/2, of slope 1:
  const double g = std::exp(-0.5);
  const double g3 = std::exp(-4.5);
  const double slope_there =
      (4 * (0.25 * g + 2.25 * g3)) / (g + g3);  // 4 Var: derivative of a normalized Gaussian mean
  const double a = 0.25 * 1e-4 * 60 / slope_there;
  const LatticeField faint = make_field(
      {16, 16, 16},
      [a](std::int64_t i, std::int64_t, std::int64_t) { return a * static_cast<double>(i - 8); });
  look.light_direction = Vec3(0.6, 0, -0.8);  // N.l = 0.6, N.e = 0
  const Vec3 to_eye(0, 0, -1);
  const Vec3 half = (Vec3(0.6, 0, -0.8) + to_eye).normalized();
  const double specular = 0.25 * 0.2 * std::pow(half.x(), 10);
  const double lit = 0.1 + 0.7 * (0.75 + 0.25 * 0.6);
  const Vec3 expected = lit * Vec3(0.2, 0.5, 0.8) + Vec3::Constant(specular);
  EXPECT_NEAR((shade_of(faint, look, front()) - expected).norm(), 0, 1e-5);
}

// A block of noise, opaque, cut by an oblique plane: the cut shows each value's colour under the
// light of a flat region. What q is left within a step of the cut changes a colour by no more than
// q (diffuse + specular). Drawn from the same plane on by depth limits, the noise is lit.
TEST(Light, CutFacesShowTheirValues) {
  const LatticeField noise =
      make_field({20, 20, 20}, [](std::int64_t i, std::int64_t j, std::int64_t k) {
        return static_cast<double>((i * 7919 + j * 104729 + k * 1299709) % 97) / 97;
      });
  Look look;
  look.transfer_function.colors = {{0, {0.4, 0.1, 0.2}}, {1, {0.6, 0.9, 0.7}}};
  look.transfer_function.opacities = {{0, 1}, {1, 1}};
  look.light_direction = Vec3(1, 0.7, -1.2);
  const Vec3 center = Vec3::Constant(9.5);
  const Vec3 direction(0.3, -0.2, 1);
  const Vec3 across = Vec3(0.5, 0.3, 1).normalized();
  constexpr double kStep = 0.05;
  for (const bool is_parallel : {true, false}) {
    const Camera camera = is_parallel ? parallel_camera(center, direction, 4)
                                      : perspective_camera(center, direction, 4, 40);
    for (const Classification classification :
         {Classification::kSampled, Classification::kPreintegrated, Classification::kRefined}) {
      const auto difference_to_flat = [&](const RenderOptions& options) {
        const Image lit = render(noise, camera, look, options).image;
        Look unlit = look;
        unlit.shade = false;
        const Image values = render(noise, camera, unlit, options).image;
        double greatest = 0;
        for (std::size_t n = 0; n < lit.rgba.size(); ++n) {
          if (n % 4 == 3) {
            EXPECT_EQ(lit.rgba[n], 1);
            continue;
          }
          const double flat = (0.1 + 0.7) * static_cast<double>(values.rgba[n]);
          greatest = std::max(greatest, std::abs(static_cast<double>(lit.rgba[n]) - flat));
        }
        return greatest;
      };
      RenderOptions options = picture(16, 16, kStep);
      options.classification = classification;
      options.clip_planes = {{2 * across, 2 * across.dot(center)}};
      EXPECT_LT(difference_to_flat(options), kStep * (0.7 + 0.2) + 1e-6);
      options.clip_planes.clear();
      draw_from(is_parallel ? 100 : 40, options);
      EXPECT_GT(difference_to_flat(options), 0.2);
    }
  }
}

// A plane whose cut is on the far side changes no light: the same picture as without it, of a field
// that is opaque before it.
TEST(Light, CutsThatAreNotSeenChangeNothing) {
  const Look look = opaque_look();
  for (const bool is_parallel : {true, false}) {
    const Camera camera = is_parallel ? front() : perspective_camera({8.5, 8, 8}, {0, 0, 1}, 3, 20);
    RenderOptions options = picture(9, 9, 0.25);
    const Image whole = render(slanted_ramp(), camera, look, options).image;
    options.clip_planes = {{{0.1, 0, -1}, -0.3}};  // less than a spacing behind what is seen
    EXPECT_EQ(render(slanted_ramp(), camera, look, options).image.rgba, whole.rgba);
  }
}

// Central differences over neighbouring samples find the same direction for a ramp across all axes
// when they span whole periods: one pixel is then a spacing. Fails for a wrong sign of y (rows go
// down) or a forgotten pitch.
TEST(Light, CentralDifferencesSeeTheSameRamp) {
  const Vec3 slope(1, -1.5, 2);
  const LatticeField ramp =
      make_field({16, 16, 16}, [&](std::int64_t i, std::int64_t j, std::int64_t k) {
        return slope.dot(Vec3(static_cast<double>(i - 8), static_cast<double>(j - 8),
                              static_cast<double>(k - 8)));
      });
  Look look = opaque_look();
  look.light_direction = Vec3(1, 0.7, -1.2);
  Camera camera = parallel_camera({8, 8, 8}, {0, 0, 1}, 2.5);
  camera.view_up = {0, 1, 0};
  const Vec3 l = look.light_direction->normalized();
  const Vec3 h = (l + Vec3(0, 0, -1)).normalized();
  const Vec3 n = slope.normalized();
  const bool is_same_side = n.dot(l) * -n.z() >= 0;
  RenderOptions options = picture(5, 5, 1);
  options.gradient = GradientMethod::kCentral;
  draw_from(97.25, options);  // away from the face, where differences are one-sided
  const Pixel at = center_pixel(render(ramp, camera, look, options).image);
  const Vec3 expected = blinn_phong(look.material, n.dot(l), n.dot(h), is_same_side);
  EXPECT_NEAR((Vec3(at.r(), at.g(), at.b()) - expected).norm(), 0, 1e-6);
}

// On a smooth field central differences with a step of 1/16 spacing are the gradient to the order
// of the step squared: in pictures of parallel and perspective cameras, with both slabs.
TEST(Light, CentralDifferencesConverge) {
  FieldSetup setup;
  setup.world_from_index = oblique_axes();
  const LatticeField field = make_field(
      {10, 10, 10},
      [](std::int64_t i, std::int64_t j, std::int64_t k) {
        return 10 * std::sin(0.5 * static_cast<double>(i + j)) + 4 * static_cast<double>(k);
      },
      setup);
  const Vec3 middle = oblique_axes() * Vec3(4.5, 4.5, 4.5);
  Look look = opaque_look();
  look.light_direction = Vec3(-1, 0.4, -0.6);
  for (const bool is_parallel : {true, false}) {
    const Camera camera = is_parallel ? parallel_camera(middle, {0.2, 0.3, 1}, 0.2)
                                      : perspective_camera(middle, {0.2, 0.3, 1}, 0.2, 15);
    for (const Slab slab : {Slab::kMid, Slab::kMean}) {
      RenderOptions options = picture(7, 5, 0.06, slab);
      draw_from(is_parallel ? 100 : 15, options);
      options.gradient = GradientMethod::kExact;
      const Image exact = render(field, camera, look, options).image;
      options.gradient = GradientMethod::kCentral;
      const Image central = render(field, camera, look, options).image;
      for (std::size_t n = 0; n < exact.rgba.size(); ++n) {
        ASSERT_NEAR(static_cast<double>(central.rgba[n]), static_cast<double>(exact.rgba[n]), 4e-3)
            << n;
      }
    }
  }
}

}  // namespace light_test
}  // namespace ovoid::test
