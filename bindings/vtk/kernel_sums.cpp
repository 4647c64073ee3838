// SPDX-License-Identifier: Apache-2.0
#include "kernel_sums.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace ovoid::mappers {
namespace {

struct Sigmas {
  double size = 0;  // the geometric mean
  double least = 0;
};

Sigmas sigmas_of(KernelShape shape, const KernelView& view, std::int32_t i) {
  std::array<double, 6> numbers{};
  for (std::size_t c = 0; c < static_cast<std::size_t>(num_shape_numbers(shape)); ++c)
    numbers[c] = view.shape[0] == nullptr ? view.shared_shape[c] : view.shape[c][i];
  if (shape == KernelShape::kBalls) return {numbers[0], numbers[0]};
  Mat3 factor;
  factor << numbers[0], 0, 0, numbers[1], numbers[2], 0, numbers[3], numbers[4], numbers[5];
  const double volume = numbers[0] * numbers[2] * numbers[5];
  Eigen::SelfAdjointEigenSolver<Mat3> solver;
  solver.computeDirect(factor * factor.transpose(), Eigen::EigenvaluesOnly);
  // By the two greater ones, which have the digits.
  const double area = std::sqrt(solver.eigenvalues()[1] * solver.eigenvalues()[2]);
  return {std::cbrt(volume), volume / area};
}

bool holds(const std::optional<Bounds3>& owned, const Vec3& place) {
  return !owned || ((place.array() >= owned->min().array()).all() &&
                    (place.array() < owned->max().array()).all());
}

}  // namespace

KernelSums kernel_sums(const KernelField& field, const std::optional<Bounds3>& owned) {
  const KernelSource& source = field.source();
  KernelSums sums{};
  for (std::int64_t b = 0; b < source.num_bricks(); ++b) {
    const KernelBrick& brick = source.brick(b);
    const KernelView view = source.acquire(b, 0);
    for (std::int32_t i = 0; i < view.count; ++i) {
      const Vec3 offset(view.center[0][i], view.center[1][i], view.center[2][i]);
      const Sigmas sigmas = sigmas_of(source.shape(), view, i);
      // Centres are rounded, not to the same place in every part: those on a side lie beyond.
      const double rounding = KernelBrick::kMaxOffsetError * sigmas.least;
      if (!holds(owned, brick.origin + offset + Vec3::Constant(rounding))) continue;
      const double area = sigmas.size * sigmas.size * sigmas.size / sigmas.least;
      const double least = std::log(sigmas.least);
      sums[0] += 1;
      sums[1] += std::log(sigmas.size);
      sums[2] += area;
      sums[3] += area * least;
      sums[4] += area * least * least;
    }
  }
  return sums;
}

double sheet_distance_of(const KernelSums& sums) {
  if (!(sums[0] > 0)) return 0;
  constexpr double kFifth = -0.842;  // of a normal distribution, standard deviations
  const double median = std::exp(sums[1] / sums[0]);
  const double mean = sums[3] / sums[2];
  const double deviation = std::sqrt(std::max(0.0, sums[4] / sums[2] - mean * mean));
  return std::clamp(2 * std::exp(mean + kFifth * deviation), 0.5 * median, median);
}

}  // namespace ovoid::mappers
