// SPDX-License-Identifier: Apache-2.0
// A kernel's shape in double precision, whatever columns it is stored in.
#pragma once

#include "ovoid/kernel_field.h"

namespace ovoid::data {

// The factor L of the covariance S = L L^T, lower triangular, world units.
inline Mat3 factor_of(KernelShape shape, const float* numbers) noexcept {
  if (shape == KernelShape::kBalls) return Mat3::Identity() * static_cast<double>(numbers[0]);
  Mat3 factor;
  factor << numbers[0], 0, 0, numbers[1], numbers[2], 0, numbers[3], numbers[4], numbers[5];
  return factor;
}

// The shape numbers of kernel `i` of a view.
inline std::array<float, 6> shape_numbers(const KernelView& view, KernelShape shape,
                                          std::int32_t i) noexcept {
  if (view.shape[0] == nullptr) return view.shared_shape;
  std::array<float, 6> numbers{};
  for (int c = 0; c < num_shape_numbers(shape); ++c) numbers[c] = view.shape[c][i];
  return numbers;
}

inline float weight_of(const KernelView& view, std::int32_t i) noexcept {
  return view.weight == nullptr ? view.shared_weight : view.weight[i];
}

inline Vec3 offset_of(const KernelView& view, std::int32_t i) noexcept {
  return {view.center[0][i], view.center[1][i], view.center[2][i]};
}

// The semi-axes (sigmas) of a shape: the square roots of the covariance's eigenvalues, rising.
Vec3 semi_axes(KernelShape shape, const float* numbers);

// The variance of a kernel of unit covariance along an axis, of which its profile says how much is
// far out: <m^2> / 3. 1 for the Gaussian, whatever its cut-off takes.
double profile_variance(KernelProfile profile, double cutoff);

}  // namespace ovoid::data
