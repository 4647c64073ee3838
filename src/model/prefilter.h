// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <stop_token>

#include "ovoid/field.h"
#include "ovoid/kernels.h"
#include "ovoid/lattice.h"

namespace ovoid::model {

// The least response of the one-axis kernel to any frequency, relative to its response to a
// constant: min over w of (g(0) + 2 sum_k g(k) cos(k w)) / (g(0) + 2 sum_k g(k)). 0.574 for the
// default kernel, there at the band limit [METHOD 7.3.2]. May be negative.
double least_response(const LatticeKernel& kernel);

// With a smaller response than this the coefficients would be the samples' noise, up to 50 times
// enlarged per axis.
inline constexpr double kMinResponse = 0.02;

// Throws Error(kInvalidArgument) that names sigma and what is allowed if least_response(kernel) <
// kMinResponse.
void require_interpolating(const LatticeKernel& kernel);

struct PrefilterOptions {
  LatticeKernel kernel;
  Reconstruction reconstruction = Reconstruction::kNormalized;
  int threads = 0;  // 0: one per hardware thread
  std::stop_token stop{};
};

// Replaces samples, x fastest, by the coefficients whose field takes the samples' values at the
// samples, at the lattice's faces too: docs/numerics.md, "The field". The field at the samples is a
// product of three matrices, one per axis,
//   A_ji = g(j - i) / sum_i g(j - i)   (normalized, i over the samples there are)    or    w1 g(j -
//   i)   (sum),
// w1 = 1 / (sqrt(2 pi) sigma), and each is inverted by elimination in its band, in double; what is
// stored between the axes is rounded to float. With the default kernel the field is right to 1e-6
// of the samples' greatest magnitude.
//
// Missing samples (not finite) are filled by the averages of their neighbours from the hole's rim
// inwards, filtered with the rest, and are NaN afterwards. Since the filled samples have no
// kernels, the field is not exact at samples within reach of a hole. At least one sample must be
// finite.
//
// Coefficients beyond float32's range are cut to it. The result does not depend on the number of
// threads. Throws Error: as require_interpolating(), kCancelled (the samples are then useless);
// std::bad_alloc. Cost: three passes over the memory.
void prefilter(std::span<float> samples, const Index3& dims, const PrefilterOptions& options);

}  // namespace ovoid::model
