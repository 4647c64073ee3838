// SPDX-License-Identifier: Apache-2.0
// Stage "project": kernels -> splats. One congruence per ellipsoid, in double precision, since the
// cut of a flat one is a difference of large numbers.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "data/kernels/kernel_shape.h"
#include "render/cpu/kernels/splat.h"
#include "render/shared/device_layout.h"

namespace ovoid::cpu {
namespace {

// In units of kLeastPixels and sheets: sigma is at least 0.65 pixels, so that the samples' sum errs
// by 2 exp(-2 pi^2 0.65^2) = 0.05 % of the mass along each axis at most, and half a sheet, as it is
// on a lattice that is sampled at its spacing.
constexpr double kLeastSquaredSigma = 0.25;
static_assert(kLeastSquaredSigma == device::kLeastSigma * device::kLeastSigma);

// True if all eigenvalues of the symmetric matrix are at least kLeastSquaredSigma: the leading
// minors of what is left when that is subtracted are not negative.
bool is_wide_enough(const Mat3& v) {
  const double a = v(0, 0) - kLeastSquaredSigma;
  const double b = v(1, 1) - kLeastSquaredSigma;
  const double c = v(2, 2) - kLeastSquaredSigma;
  if (!(a >= 0 && b >= 0 && c >= 0)) return false;
  const double ab = a * b - v(0, 1) * v(0, 1);
  if (!(ab >= 0)) return false;
  const double det =
      c * ab - a * v(1, 2) * v(1, 2) - b * v(0, 2) * v(0, 2) + 2 * v(0, 1) * v(1, 2) * v(0, 2);
  return det >= -1e-9 * v(0, 0) * v(1, 1) * v(2, 2);
}

// Raises eigenvalues.
void widen(Mat3& covariance) {
  Eigen::SelfAdjointEigenSolver<Mat3> solver;
  solver.computeDirect(covariance);
  const Vec3 after = solver.eigenvalues().cwiseMax(kLeastSquaredSigma);
  covariance = solver.eigenvectors() * after.asDiagonal() * solver.eigenvectors().transpose();
}

// The splat's shape, from the covariance in units of kLeastPixels, `lateral` pixels of the focal
// plane each, and sheets.
void set_ellipsoid(Splat& splat, Mat3 v, double mass, double lateral, double cutoff) {
  v.topLeftCorner<2, 2>() *= lateral * lateral;
  v.topRightCorner<2, 1>() *= lateral;
  v.bottomLeftCorner<1, 2>() *= lateral;

  const double vss = v(2, 2);
  const double mx = v(0, 2) / vss;
  const double my = v(1, 2) / vss;
  const double cxx = v(0, 0) - mx * v(0, 2);
  const double cxy = v(0, 1) - mx * v(1, 2);
  const double cyy = v(1, 1) - my * v(1, 2);
  const double det = cxx * cyy - cxy * cxy;
  const double half_trace = 0.5 * (cxx + cyy);
  const double spread = std::sqrt(std::max(half_trace * half_trace - det, 0.0));
  splat.axx = static_cast<float>(cyy / det);
  splat.axy = static_cast<float>(-cxy / det);
  splat.ayy = static_cast<float>(cxx / det);
  splat.mx = static_cast<float>(mx);
  splat.my = static_cast<float>(my);
  splat.inverse_var_s = static_cast<float>(1 / vss);
  splat.weight = static_cast<float>(mass);
  splat.reach_s = static_cast<float>(cutoff * std::sqrt(vss));
  splat.reach_x = static_cast<float>(cutoff * std::sqrt(cxx));
  splat.reach_y = static_cast<float>(cutoff * std::sqrt(cyy));
  splat.minor = static_cast<float>(std::sqrt(det / (half_trace + spread)));
}

// The map from camera coordinates to units in which a splat's least sigma is a half.
struct SplatUnits {
  SplatUnits(const view::SplatSpace& space, double depth) {
    // Kernels at or behind the eye are as fine as those at the near plane.
    const double depth_scale =
        space.is_parallel ? 1.0
                          : std::max(depth, 0.5 * space.sampling_distance) / space.focal_depth;
    per_pixels = 1 / (space.pitch * depth_scale * view::kLeastPixels);
    per_sheets = 1 / space.sampling_distance;
    lateral = depth_scale * view::kLeastPixels;
  }

  Mat3 scale() const { return Vec3(per_pixels, per_pixels, per_sheets).asDiagonal(); }

  double per_pixels, per_sheets;  // per world unit
  double lateral;                 // pixels of the focal plane in a unit
};

Splat splat_at(const view::SplatSpace& space, const Vec3& at) {
  Splat splat;
  splat.x = static_cast<float>(at[0] / space.pitch);
  splat.y = static_cast<float>(at[1] / space.pitch);
  splat.s = static_cast<float>(space.sheet_of(at[2]));
  splat.value = splat.color = 0;
  return splat;
}

}  // namespace

// Without matrices: there are millions of balls.
Splat project_ball(const view::SplatSpace& space, const Vec3& center_world, double sigma,
                   double cutoff) {
  const Vec3 at = space.camera_from_world(center_world);
  const SplatUnits units(space, at[2]);
  const double least = std::sqrt(kLeastSquaredSigma);
  const double across = sigma * units.per_pixels, along = sigma * units.per_sheets;
  const double wide_across = std::max(across, least), wide_along = std::max(along, least);
  const double pixels = wide_across * units.lateral;
  Splat splat = splat_at(space, at);
  splat.axx = splat.ayy = static_cast<float>(1 / (pixels * pixels));
  splat.axy = splat.mx = splat.my = 0;
  splat.inverse_var_s = static_cast<float>(1 / (wide_along * wide_along));
  splat.weight =
      static_cast<float>(across * across * along / (wide_across * wide_across * wide_along));
  splat.reach_s = static_cast<float>(cutoff * wide_along);
  splat.reach_x = splat.reach_y = static_cast<float>(cutoff * pixels);
  splat.minor = static_cast<float>(pixels);
  return splat;
}

Splat project_small_balls(const view::SplatSpace& space, const Vec3& center_world, double sigma,
                          const Mat3& spread, double cutoff) {
  const Vec3 at = space.camera_from_world(center_world);
  const SplatUnits units(space, at[2]);
  const Mat3 map = units.scale() * space.rotation;
  const Mat3 covariance =
      Mat3(kLeastSquaredSigma * Mat3::Identity()) + map * spread * map.transpose();
  const double volume = std::pow(sigma, 3) * std::abs(map.determinant());
  Splat splat = splat_at(space, at);
  set_ellipsoid(splat, covariance, volume / std::sqrt(covariance.determinant()), units.lateral,
                cutoff);
  return splat;
}

Splat project_kernel(const view::SplatSpace& space, const Vec3& center_world, KernelShape shape,
                     const float* numbers, double cutoff) {
  if (shape == KernelShape::kBalls) return project_ball(space, center_world, numbers[0], cutoff);
  const Vec3 at = space.camera_from_world(center_world);
  const SplatUnits units(space, at[2]);
  const Mat3 factor = units.scale() * (space.rotation * data::factor_of(shape, numbers));
  Mat3 covariance = factor * factor.transpose();
  double mass = 1;
  if (!is_wide_enough(covariance)) {
    const double volume = std::abs(factor.determinant());
    widen(covariance);
    mass = volume / std::sqrt(covariance.determinant());
  }
  Splat splat = splat_at(space, at);
  set_ellipsoid(splat, covariance, mass, units.lateral, cutoff);
  return splat;
}

}  // namespace ovoid::cpu
