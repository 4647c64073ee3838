// SPDX-License-Identifier: Apache-2.0
// Line integrals: the projection of one kernel, its mass, and lengths of boxes.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "render/reference/reference_renderer.h"
#include "support/scenes.h"
#include "support/tolerances.h"
#include "support/volumes.h"

namespace ovoid::test {
namespace xray_test {

using reference::render;

Look xray() { return with_mode(uniform_look(1), Mode::kXray); }

LatticeField kernel_field(const Affine3& world_from_index, double value = 1,
                          LatticeKernel kernel = {}) {
  FieldSetup setup;
  setup.world_from_index = world_from_index;
  setup.kernel = kernel;
  setup.reconstruction = Reconstruction::kSum;
  return constant_field({1, 1, 1}, value, setup);
}

// Position on the picture plane of a pixel, from the picture's middle, world units.
double across(int x, const RenderOptions& options, double half_height) {
  return (2 * (x + 0.5) / options.width - 1) * half_height * options.width / options.height;
}
double upwards(int y, const RenderOptions& options, double half_height) {
  return (1 - 2 * (y + 0.5) / options.height) * half_height;
}

// Along an axis: v (pi / 2)^(-3/2) g(x) g(y) sqrt(pi / 2) erf(4 / sqrt 2), and nothing beyond the
// box. Fails for a wrong camera frame, row order, path or amplitude.
TEST(Xray, KernelAlongAnAxis) {
  Camera camera = parallel_camera(Vec3::Zero(), {0, 0, -1}, 2.5);
  camera.view_up = {0, 1, 0};  // right is then +x
  const double value = 3.5;
  const double amplitude = value * std::erf(4 / std::numbers::sqrt2) / (std::numbers::pi / 2);
  for (const double ds : {1.0, 0.37, 2.6}) {
    const RenderOptions options = picture(47, 33, ds, Slab::kMean);
    const Image image =
        render(kernel_field(scaled_axes({1, 1, 1}), value), camera, xray(), options).image;
    for (int y = 0; y < options.height; ++y) {
      for (int x = 0; x < options.width; ++x) {
        const double px = across(x, options, 2.5);
        const double py = upwards(y, options, 2.5);
        const bool is_inside = std::abs(px) <= 2 && std::abs(py) <= 2;
        const double expected = is_inside ? amplitude * std::exp(-2 * (px * px + py * py)) : 0;
        ASSERT_NEAR(pixel(image, x, y).r(), expected, kFloatRelative * amplitude) << x << " " << y;
        ASSERT_EQ(pixel(image, x, y).a(), is_inside ? 1 : 0) << x << " " << y;
      }
    }
  }
}

// Right is right and up is up: a kernel off the centre shows in the quadrant it lies in.
TEST(Xray, PictureIsNotMirrored) {
  Camera camera = parallel_camera({-1.0, -0.5, 0}, {0, 0, -1}, 3);
  camera.view_up = {0, 1, 0};
  const Image image =
      render(kernel_field(scaled_axes({1, 1, 1})), camera, xray(), picture(12, 12)).image;
  // The kernel at the origin lies right of and above the focal point: pixels of half a unit.
  EXPECT_GT(pixel(image, 7, 4).r(), 10 * pixel(image, 3, 4).r());
  EXPECT_GT(pixel(image, 7, 4).r(), 2 * pixel(image, 7, 8).r());
}

// Obliquely through an anisotropic, sheared kernel: the projection of a Gaussian with covariance A
// A^T sigma^2 and mass v |det A|. What the box cuts off is told by kCutOffShare.
TEST(Xray, KernelAlongAnyDirection) {
  const Affine3 axes = oblique_axes();
  const double value = 2;
  const double mass = value * std::abs(axes.linear().determinant());
  const Mat3 covariance = 0.25 * axes.linear() * axes.linear().transpose();
  const RenderOptions options = picture(31, 31, 0.4, Slab::kMean);
  for (const Vec3& direction : {Vec3(1, 2, -0.5), Vec3(-0.3, 0.2, 1), Vec3(0, 1, 1)}) {
    const Camera camera = parallel_camera(axes.translation(), direction, 2.2);
    const Vec3 right = direction.normalized().cross(camera.view_up).normalized();
    const Vec3 up = right.cross(direction.normalized());
    Eigen::Matrix<double, 3, 2> frame;
    frame << right, up;
    const Eigen::Matrix2d projected = frame.transpose() * covariance * frame;
    const double peak = mass / (2 * std::numbers::pi * std::sqrt(projected.determinant()));
    const Image image = render(kernel_field(axes, value), camera, xray(), options).image;
    for (int y = 0; y < options.height; ++y) {
      for (int x = 0; x < options.width; ++x) {
        const Eigen::Vector2d q(across(x, options, 2.2), upwards(y, options, 2.2));
        const double expected = peak * std::exp(-0.5 * q.dot(projected.inverse() * q));
        ASSERT_NEAR(pixel(image, x, y).r(), expected, peak * kCutOffShare) << x << " " << y;
      }
    }
  }
}

double image_mass(const Image& image, double half_height) {
  const double pitch = 2 * half_height / image.height;
  double mass = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) mass += pixel(image, x, y).r() * pitch * pitch;
  }
  return mass;
}

// The picture holds the kernel's mass, value times cell volume. The sum over pixels is a quadrature
// with a step of a third of sigma or less, exact but for the jumps at the box: kCutOffShare.
TEST(Xray, MassOfAKernel) {
  const Affine3 axes = oblique_axes();
  const double mass = 2 * std::abs(axes.linear().determinant());
  const Camera camera = parallel_camera(axes.translation(), {1, -2, 0.7}, 5);
  for (const Slab slab : {Slab::kMean, Slab::kMid}) {
    // Middle planes 0.1 apart, a quarter of the smallest sigma across: their quadrature is as
    // exact.
    const Image image =
        render(kernel_field(axes, 2), camera, xray(), picture(60, 60, 0.1, slab)).image;
    EXPECT_NEAR(image_mass(image, 5), mass, mass * 2 * kCutOffShare);
  }
}

// Minified, kernels are widened and amplitudes lowered: a ball of 12 spacings shown on pixels of 3
// keeps its mass, up to the ripple of a lattice of pixels, twice kAxisRipple. Without widening
// single pixels would take what happens to lie at their centres; without the factors m the mass
// would be 27-fold.
TEST(Xray, MassIsKeptWhenMinified) {
  FieldSetup setup;
  setup.reconstruction = Reconstruction::kSum;
  double mass = 0;
  const auto ball = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    const Vec3 d(static_cast<double>(i) - 15, static_cast<double>(j) - 15,
                 static_cast<double>(k) - 15);
    return d.norm() < 6 && (i + j + k) % 2 == 0 ? 5.0 : 0.0;
  };
  for (int k = 0; k < 31; ++k) {
    for (int j = 0; j < 31; ++j) {
      for (int i = 0; i < 31; ++i) mass += ball(i, j, k);
    }
  }
  const LatticeField field = make_field({31, 31, 31}, ball, setup);
  for (const Vec3& shift : {Vec3(0, 0, 0), Vec3(0.9, -1.3, 0.4)}) {
    const Camera camera = parallel_camera(Vec3(15, 15, 15) + shift, {0.2, -0.1, 1}, 24);
    const Image image = render(field, camera, xray(), picture(16, 16, 1)).image;
    EXPECT_NEAR(image_mass(image, 24), mass, mass * (2 * kAxisRipple + kCutOffShare));
  }
}

// The integral does not depend on where slabs are cut, for sums; a constant normalized box gives
// value times length.
TEST(Xray, LengthOfABox) {
  const LatticeField box = constant_field({8, 8, 8}, -2.5);
  const Camera camera = parallel_camera({3.5, 3.5, 3.5}, {0, 0, 1}, 4);
  for (const Slab slab : {Slab::kMid, Slab::kMean}) {
    for (const double ds : {1.0, 0.5, 0.25, 2.0}) {
      const Image image = render(box, camera, xray(), picture(9, 9, ds, slab)).image;
      EXPECT_NEAR(center_pixel(image).r(), -2.5 * 8, 20 * kFloatRelative) << ds;
      EXPECT_EQ(center_pixel(image).g(), center_pixel(image).r());
      EXPECT_EQ(center_pixel(image).a(), 1);
      // The first sheet's plane is ds / 2 behind the face at -1/2.
      EXPECT_NEAR(center_depth(image), 100 - 4 + ds / 2, 100 * kFloatRelative) << ds;
    }
  }
}

}  // namespace xray_test
}  // namespace ovoid::test
