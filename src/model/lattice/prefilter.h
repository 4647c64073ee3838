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
// published kernel, 1/3 for the B-spline, both at the band limit [METHOD 7.3.2]; 1 for kernels that
// interpolate. May be negative.
double least_response(const LatticeKernel& kernel);

// With a smaller response than this the coefficients would be the samples' noise, up to 50 times
// enlarged per axis.
inline constexpr double kMinResponse = 0.02;

// Throws Error(kInvalidArgument) that names sigma and what is allowed if least_response(kernel) <
// kMinResponse.
void require_interpolating(const LatticeKernel& kernel);

struct PrefilterOptions {
  LatticeKernel kernel;  // in spacings
  Reconstruction reconstruction = Reconstruction::kNormalized;
  int threads = 0;  // 0: one per hardware thread
  std::stop_token stop{};
  ValueRange range{};    // of the samples; empty: not known
  bool may_miss = true;  // some samples may be missing
};

// Replaces samples, x fastest, by the coefficients whose field takes the samples' values at the
// samples, at the lattice's faces too: docs/numerics.md, "Prefilter". The field at the samples of a
// Cartesian lattice is a product of three matrices, one per axis,
//   A_ji = g(j - i) / sum_i g(j - i)   (normalized, i over the samples there are)    or    w1 g(j -
//   i)   (sum),
// w1 the inverse of the kernel's mass, and each is inverted by elimination in its band, in floats.
// Elimination of such matrices is stable: the field is right to 2e-6 of the coefficients' greatest
// magnitude.
//
// Missing samples (not finite) are filled by the averages of their neighbours from the hole's rim
// inwards, filtered with the rest, and are NaN afterwards. Since the filled samples have no
// kernels, the field is not exact at samples within reach of a hole. At least one sample must be
// finite.
//
// Coefficients beyond float32's range are cut to it. The result does not depend on the number of
// threads. Throws Error: as require_interpolating(), kCancelled (the samples are then useless);
// std::bad_alloc. Cost: two passes over the memory.
void prefilter(std::span<float> samples, const Index3& dims, const PrefilterOptions& options);

// The same for body-centred lattices, whose matrix is no product: conjugate gradients with the
// operator of the whole lattice, until the field at the samples is right to kBodyCentredError of
// their range. Throws also Error(kInvalidArgument) where that does not come about, as with kernels
// too wide. Cost: some 15 passes of about 40 multiplications for each sample, 3 times the memory.
void prefilter_body_centred(std::span<float> samples, const Index3& dims,
                            const PrefilterOptions& options);
inline constexpr double kBodyCentredError = 1e-5;

}  // namespace ovoid::model
