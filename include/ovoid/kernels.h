// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include "ovoid/export.h"

namespace OVOID_API ovoid {

// Least and greatest value; empty (lo > hi) when there is no sample.
struct ValueRange {
  float lo = 1.0F;
  float hi = -1.0F;
  bool is_empty() const noexcept { return lo > hi; }
};

// What a lattice's kernel looks like along one axis (docs/numerics.md, "The kernel").
enum class LatticeKernelKind : std::uint8_t {
  kGaussian,    // exp(-1/2 (d / sigma)^2), cut; as published
  kBSpline,     // cubic B-spline: twice continuously differentiable, never negative
  kCatmullRom,  // interpolates the samples as they are; once differentiable, negative in places
};
const char* name_of(LatticeKernelKind kind) noexcept;  // "gaussian", "bspline", "catmull-rom"

// The shared kernel of a lattice: phi(d) is the product of one function of each d_a, d in lattice
// axes and in spacings of each axis. Its support is the BOX |d_a| <= support_radius(). The default
// is the published kernel, exp(-2 r^2) cut at two spacings: four samples reach any position along
// each axis, as they do with the kinds of one size. Source: [Neophytou 2006, eq. 7].
struct LatticeKernel {
  // The Gaussian's. Kinds of one size have these two values and no others; they stand for their
  // width where one is asked for (widening, nodes).
  double sigma = 0.5;   // spacings, in [kMinSigma, kMaxSigma]
  double cutoff = 4.0;  // sigmas, in (0, kMaxCutoff]; support_radius() must be at least kMinSupport
  LatticeKernelKind kind = LatticeKernelKind::kGaussian;

  static constexpr double kMinSigma = 0.1;
  static constexpr double kMaxSigma = 4.0;
  static constexpr double kMaxCutoff = 16.0;
  static constexpr double kMinSupport = 0.5;  // below half a spacing the kernels leave gaps

  // Spacings. What misses a whole number by a cut-off's last typed digit, as 0.6 * 3.3333333 does,
  // is that number: else the taps at that distance would be lost on the planes of samples alone.
  double support_radius() const noexcept {
    const double radius = sigma * cutoff;
    const double whole = std::round(radius);
    return std::abs(radius - whole) <= kSupportRounding ? whole : radius;
  }
  static constexpr double kSupportRounding = 1e-6;

  bool operator==(const LatticeKernel&) const = default;
};
inline constexpr LatticeKernel kBSplineKernel{.kind = LatticeKernelKind::kBSpline};
inline constexpr LatticeKernel kCatmullRomKernel{.kind = LatticeKernelKind::kCatmullRom};

// How a field is summed from its kernels (docs/numerics.md, "The field").
enum class Reconstruction {
  kNormalized,  // sum w v phi / sum w phi over the kernels that exist; undefined where the
                // denominator is too small
  kSum,         // sum w v phi, with w = cell volume / integral of phi; fades to zero outside
};

const char* name_of(Reconstruction reconstruction) noexcept;  // "normalized", "sum"

}  // namespace ovoid
