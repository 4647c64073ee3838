// SPDX-License-Identifier: Apache-2.0
#include "model/mesh/ellipsoid_shape.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace ovoid::model {

namespace {

// Of the longest axis, shorter ones are taken for rounding: coordinates of float32 leave 1e-6.
constexpr double kNoLength = 1e-5;

Mat3 cholesky(const Mat3& matrix) {
  const Eigen::LLT<Mat3> decomposition(matrix);
  return decomposition.matrixL();
}

}  // namespace

// Without forming the product, which would square the axes' ratio: the R of a QR decomposition of
// its root.
Mat3 factor_of_axes(const Mat3& vectors, const Vec3& axes) {
  const Mat3 root = vectors * axes.asDiagonal();
  const Mat3 upper = root.transpose().householderQr().matrixQR().triangularView<Eigen::Upper>();
  Mat3 factor = upper.transpose();
  for (int c = 0; c < 3; ++c) {
    if (factor(c, c) < 0) factor.col(c) *= -1;
  }
  return factor;
}

EllipsoidShape shape_of_covariance(const Mat3& covariance, Extent3 extent) {
  EllipsoidShape shape;
  const double greatest = covariance.diagonal().cwiseAbs().maxCoeff();
  if (!(greatest > 0) || !std::isfinite(greatest)) {
    shape.rank = 0;
    shape.is_degenerate = true;
    return shape;
  }
  const Mat3 unit = covariance / greatest;
  // The determinant bounds the least eigenvalue from below, since the others are at most the trace.
  // Most kernels need no eigenvectors.
  const double trace = unit.trace();
  if (extent == Extent3::kSolid && unit.determinant() > 1e-6 * trace * trace * trace) {
    shape.factor = std::sqrt(greatest) * cholesky(unit);
    return shape;
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(unit);
  Vec3 axes = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  const Vec3 before = axes;
  shape.rank = static_cast<int>((axes.array() >= kNoLength * axes[2]).count());
  for (int a = 1; a >= 0; --a) {
    const bool is_flat = axes[a] < kNoLength * axes[2] || (a == 0 && extent == Extent3::kFlat);
    axes[a] = std::max(axes[a], is_flat ? kFlatAxisRatio * axes[a + 1] : kLeastAxisRatio * axes[2]);
  }
  shape.is_degenerate = axes != before;
  if (!shape.is_degenerate) {  // thin, but as it is: no rounding through eigenvectors
    const Eigen::LLT<Mat3> decomposition(unit);
    if (decomposition.info() == Eigen::Success) {
      shape.factor = std::sqrt(greatest) * Mat3(decomposition.matrixL());
      return shape;
    }
  }
  shape.factor = std::sqrt(greatest) * factor_of_axes(solver.eigenvectors(), axes);
  return shape;
}

EllipsoidShape limited_shape(const Mat3& covariance, double least_ratio) {
  EllipsoidShape shape;
  const double greatest = covariance.diagonal().cwiseAbs().maxCoeff();
  if (!(greatest > 0) || !std::isfinite(greatest)) {
    shape.rank = 0;
    shape.is_degenerate = true;
    return shape;
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(covariance / greatest);
  const Vec3 axes = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  const Vec3 limited = axes.cwiseMax(least_ratio * axes[2]);
  shape.is_degenerate = limited != axes;
  shape.factor = std::sqrt(greatest) * factor_of_axes(solver.eigenvectors(), limited);
  return shape;
}

SiteKernel kernel_of_volume(const EllipsoidShape& shape, double volume) {
  SiteKernel kernel;
  kernel.is_alone = shape.rank == 0;
  kernel.is_degenerate = shape.is_degenerate;
  const double wanted = std::cbrt(volume / 8 / shape.factor.determinant());
  const double scale = std::clamp(wanted, kLeastScale, kMostScale);
  kernel.factor = scale * shape.factor;
  // Where the shape could not follow, the volume cannot be trusted either: only a part of it.
  kernel.weight = kLatticeWeight * std::clamp(std::pow(wanted / scale, 3.0), 0.25, 4.0);
  return kernel;
}

}  // namespace ovoid::model
