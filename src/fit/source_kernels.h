// SPDX-License-Identifier: Apache-2.0
// What a fit starts from: a kernel field's kernels as plain columns, as Gaussian ellipsoids.
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "ovoid/kernel_field.h"

namespace ovoid::fit {

struct SourceKernels {
  double cutoff = 4;
  Reconstruction reconstruction = Reconstruction::kNormalized;
  std::vector<KernelAttribute> attributes;
  std::vector<double> centers;             // [n, 3]
  std::vector<float> shapes;               // [n, 6]
  std::vector<float> weights;              // [n]
  std::vector<float> sums;                 // [n] of weights at the centres
  std::vector<double> volumes;             // [n] world: what each stands for
  std::vector<std::vector<float>> values;  // of each attribute [n]

  std::size_t count() const noexcept { return weights.size(); }
  Vec3 center(std::size_t i) const noexcept {
    return {centers[3 * i], centers[3 * i + 1], centers[3 * i + 2]};
  }
  Mat3 factor(std::size_t i) const noexcept;
  double det(std::size_t i) const noexcept {
    const float* const l = shapes.data() + 6 * i;
    return static_cast<double>(l[0]) * static_cast<double>(l[2]) * static_cast<double>(l[5]);
  }
  // To be borrowed while these live.
  KernelColumns columns() const;
};

// Kernels of other profiles become Gaussians of the same integral and variance. Throws what the
// source throws, and Error(kCancelled).
SourceKernels load_source_kernels(const KernelField& field, int threads,
                                  const std::stop_token& stop);

}  // namespace ovoid::fit
