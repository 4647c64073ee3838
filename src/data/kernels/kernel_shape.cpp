// SPDX-License-Identifier: Apache-2.0
#include "data/kernels/kernel_shape.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace ovoid::data {

// The closed form for eigenvalues errs by some 1e-15 of the largest one, so the two larger axes are
// good to a hundredth for ratios up to 1:10000 or so; the smallest follows from the determinant,
// which loses nothing.
Vec3 semi_axes(KernelShape shape, const float* numbers) {
  if (shape == KernelShape::kBalls) return Vec3::Constant(numbers[0]);
  const Mat3 factor = factor_of(shape, numbers);
  const double greatest = factor.cwiseAbs().maxCoeff();
  const Mat3 unit = factor / greatest;
  Eigen::SelfAdjointEigenSolver<Mat3> solver;
  solver.computeDirect(unit * unit.transpose(), Eigen::EigenvaluesOnly);
  Vec3 axes = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  const double volume = unit(0, 0) * unit(1, 1) * unit(2, 2);
  axes[1] = std::max(axes[1], std::sqrt(volume / axes[2]));  // the middle one is not the least
  axes[0] = std::min(volume / (axes[1] * axes[2]), axes[1]);
  return greatest * axes;
}

double profile_variance(KernelProfile profile, double cutoff) {
  if (profile == KernelProfile::kGaussian) return 1.0;
  // By the midpoint rule, which errs by the step squared.
  constexpr int kSteps = 4096;
  double mass = 0, moment = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double m = cutoff * (i + 0.5) / kSteps;
    const double shell = m * m * profile_value(profile, m, cutoff);
    mass += shell;
    moment += m * m * shell;
  }
  return moment / (3 * mass);
}

}  // namespace ovoid::data
