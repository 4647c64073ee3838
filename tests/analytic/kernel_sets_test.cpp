// SPDX-License-Identifier: Apache-2.0
// Kernel sets against closed forms.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

#include "render/cpu/kernels/splat.h"
#include "render/shared/sections.h"
#include "support/agreement.h"
#include "support/kernel_sets.h"
#include "support/scenes.h"

namespace ovoid::test {
namespace kernel_sets_test {

constexpr double kSixDigits = 0.5e-6 * (1 + 1e-9);

Mat3 turn(double degrees, const Vec3& axis) {
  return Eigen::AngleAxisd(degrees * std::numbers::pi / 180, axis).toRotationMatrix();
}

// METHOD's ellipsoid: half-axes 1.5, 0.8, 0.5, turned by 30 degrees about z, then 40 about x. Its
// kernel is exp(-2 q), so the half-axes are twice the sigmas.
Mat3 known_covariance() {
  const Mat3 rotation = turn(40, Vec3::UnitX()) * turn(30, Vec3::UnitZ());
  const Vec3 sigmas = 0.5 * Vec3(1.5, 0.8, 0.5);
  return rotation * sigmas.cwiseAbs2().asDiagonal() * rotation.transpose();
}

std::array<float, 6> factor_numbers(const Mat3& covariance) {
  const Mat3 factor = covariance.llt().matrixL();
  std::array<float, 6> numbers{};
  std::size_t n = 0;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c <= r; ++c) numbers[n++] = static_cast<float>(factor(r, c));
  }
  return numbers;
}

// Fine samples, so that nothing is widened.
constexpr double kPitch = 0.05;

cpu::Splat known_splat() {
  view::SplatSpace space{};
  space.origin = Vec3::Zero();
  space.rotation = Mat3::Identity();
  space.pitch = space.sampling_distance = kPitch;
  space.focal_depth = 1;
  space.first_depth = 1;
  space.is_parallel = true;
  const auto numbers = factor_numbers(known_covariance());
  return cpu::project_kernel(space, Vec3::Zero(), KernelShape::kEllipsoids, numbers.data(), 4);
}

TEST(EllipsoidSection, ShapeHasTheKnownDigits) {
  const Mat3 sigma = 4 * known_covariance();
  EXPECT_NEAR(sigma(0, 0), 1.847500, kSixDigits);
  EXPECT_NEAR(sigma(0, 1), 0.534048, kSixDigits);
  EXPECT_NEAR(sigma(2, 2), 0.577442, kSixDigits);
  const cpu::Splat splat = known_splat();
  const double per_world = 1 / (4 * kPitch * kPitch);
  constexpr double kFloat = 2e-6;
  EXPECT_NEAR(splat.mx, 0.776043, kFloat);
  EXPECT_NEAR(splat.my, 0.675791, kFloat);
  EXPECT_NEAR(splat.inverse_var_s * per_world, 1.731776, kFloat);
  EXPECT_NEAR(splat.axx * per_world, 0.723958, kFloat);
  EXPECT_NEAR(splat.axy * per_world, -0.370867, kFloat);
  EXPECT_NEAR(splat.ayy * per_world, 2.405591, kFloat);
  EXPECT_NEAR(splat.reach_s * kPitch, 1.519792, kFloat);
  EXPECT_NEAR(splat.weight, 1.0, 1e-6);
}

TEST(EllipsoidSection, SlabHasTheKnownDigits) {
  const Mat3 covariance = known_covariance();
  const double sigma = std::sqrt(covariance(2, 2));
  const SlabMoments moments = slab_moments(-0.25 / sigma, 0.75 / sigma);
  EXPECT_NEAR(moments.weight * sigma, 0.686227, 1e-6);
  EXPECT_NEAR(moments.mean * sigma, 0.139439, 1e-6);
  EXPECT_NEAR(moments.variance * sigma * sigma, 0.060075, 1e-6);
  const Eigen::Vector2d m = covariance.topRightCorner<2, 1>() / covariance(2, 2);
  const Eigen::Matrix2d c2 =
      covariance.topLeftCorner<2, 2>() - covariance.topRightCorner<2, 1>() * m.transpose();
  const Eigen::Matrix2d c3 = c2 + moments.variance * sigma * sigma * m * m.transpose();
  EXPECT_NEAR(c3(0, 0), 0.411115, 1e-6);
  EXPECT_NEAR(c3(0, 1), 0.089309, 1e-6);
  EXPECT_NEAR(c3(1, 1), 0.140272, 1e-6);
  EXPECT_NEAR(moments.weight * sigma * std::sqrt(c2.determinant() / c3.determinant()), 0.607663,
              1e-6);
}

KernelNumbers one_ellipsoid(const Vec3& center, const Vec3& sigmas, const Mat3& rotation) {
  KernelNumbers set;
  set.add(center, sigmas, rotation, {2.5F});
  return set;
}

Look xray_look() {
  Look look = uniform_look(1);
  look.mode = Mode::kXray;
  return look;
}

// Of the Gaussian profile, along lines that pass its middle at m^2 = q, in units of the uncut one's
// through the middle.
double line_integral(double q, double cutoff) {
  const double end = std::sqrt(std::max(cutoff * cutoff - q, 0.0));
  const double tangent = std::exp(-0.5 * cutoff * cutoff) * (2 * end + 2 * end * end * end / 3) /
                         std::sqrt(2 * std::numbers::pi);
  return std::exp(-0.5 * q) * std::erf(end / std::numbers::sqrt2) - tangent;
}

// The line integrals of an ellipsoid, however it and the camera are turned, are the profile's.
TEST(KernelSets, XraysAreLineIntegrals) {
  for (int turn_number = 0; turn_number < 6; ++turn_number) {
    const Mat3 rotation = some_rotation(turn_number);
    const Vec3 sigmas(0.3, 0.12, 0.05);
    const KernelNumbers numbers = one_ellipsoid(Vec3(1, 2, 3), sigmas, rotation);
    const KernelField field(numbers.source(), Reconstruction::kSum);
    const double half_height = 1.3;
    const TestScene scene{field, parallel_camera(Vec3(1, 2, 3), Vec3(0, 0, -1), half_height),
                          xray_look(), picture(80, 80, 0.11, Slab::kAuto)};
    const Mat3 s = rotation * sigmas.cwiseAbs2().asDiagonal() * rotation.transpose();
    const Eigen::Matrix2d across = s.topLeftCorner<2, 2>();
    const double weight = static_cast<double>(numbers.weights[0]) * 2.5;
    const double peak =
        weight * std::sqrt(2 * std::numbers::pi * s.determinant() / across.determinant());
    const Image image = draw(scene).image;
    double worst = 0;
    for (int y = 0; y < 80; ++y) {
      for (int x = 0; x < 80; ++x) {
        const Eigen::Vector2d u((2 * (x + 0.5) / 80 - 1) * half_height,
                                (1 - 2 * (y + 0.5) / 80) * half_height);
        const double expected = peak * line_integral(u.dot(across.inverse() * u), 4);
        worst = std::max(worst, std::abs(pixel(image, x, y).r() - expected));
      }
    }
    // What the sections' one Gaussian for a part of a slanted ellipsoid leaves.
    EXPECT_LT(worst / peak, kSectionsShare) << "turn " << turn_number;
  }
}

// A picture's sum is the mass, for kernels of any size at any place within a pixel: nothing is lost
// below a pixel or between two sheets.
TEST(KernelSets, XraysKeepTheMass) {
  for (const double sigma : {0.002, 0.01, 0.03, 0.1, 0.4}) {
    for (const bool uses_levels : {false, true}) {
      KernelNumbers numbers;
      numbers.shape = KernelShape::kBalls;
      for (int i = 0; i < 20; ++i)
        numbers.add(Vec3(0.0371 * i, 0.0213 * i, 0.0457 * i), Vec3::Constant(sigma),
                    Mat3::Identity(), {1.0F});
      const KernelField field(numbers.source(), Reconstruction::kSum);
      TestScene scene{field, parallel_camera(Vec3(0.4, 0.2, 0.4), Vec3(0.3, -0.2, -1), 3.0),
                      xray_look(), picture(120, 120, 0.07, Slab::kAuto)};
      if (!uses_levels) scene.options.post_convolution = PostConvolution::kOff;
      const Image image = draw(scene).image;
      double sum = 0;
      for (std::size_t p = 0; p < image.rgba.size() / 4; ++p)
        sum += static_cast<double>(image.rgba[4 * p]);
      const double area = std::pow(6.0 / 120, 2);
      double mass = 0;
      for (const float weight : numbers.weights)
        mass += static_cast<double>(weight) * profile_integral(KernelProfile::kGaussian, 4) *
                sigma * sigma * sigma;
      EXPECT_NEAR(sum * area / mass, 1.0, 1e-3) << sigma;
    }
  }
}

// Where all values are one, so is the field, whatever the kernels and levels.
TEST(KernelSets, AConstantIsConstant) {
  KernelNumbers numbers = jittered_ellipsoids(8);
  std::fill(numbers.values[0].begin(), numbers.values[0].end(), 3.25F);
  const KernelField field(numbers.source(), Reconstruction::kNormalized);
  TestScene scene{field, parallel_camera(Vec3(0.5, 0.5, 0.5), Vec3(0.3, 0.5, -1), 0.2),
                  uniform_look(1), picture(90, 90, 0, Slab::kMid)};
  scene.look.mode = Mode::kMaximum;
  scene.look.transfer_function = gray_look(3.2, 3.3).transfer_function;
  const Image image = draw(scene).image;
  for (std::size_t p = 0; p < image.rgba.size() / 4; ++p)
    ASSERT_NEAR(image.rgba[4 * p], 0.5, 1e-3) << p;
}

}  // namespace kernel_sets_test
}  // namespace ovoid::test
