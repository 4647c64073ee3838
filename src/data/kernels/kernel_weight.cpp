// SPDX-License-Identifier: Apache-2.0
#include "data/kernels/kernel_weight.h"

#include <cmath>
#include <numbers>

namespace ovoid {

const char* name_of(LatticeKernelKind kind) noexcept {
  switch (kind) {
    case LatticeKernelKind::kGaussian:
      return "gaussian";
    case LatticeKernelKind::kBSpline:
      return "bspline";
    case LatticeKernelKind::kCatmullRom:
      return "catmull-rom";
  }
  return "";
}

const char* name_of(Reconstruction reconstruction) noexcept {
  return reconstruction == Reconstruction::kNormalized ? "normalized" : "sum";
}

namespace data {

bool is_piecewise(LatticeKernelKind kind) noexcept { return kind != LatticeKernelKind::kGaussian; }

KernelPieces pieces_of(LatticeKernelKind kind) noexcept {
  if (kind == LatticeKernelKind::kCatmullRom)
    return {{1.0, 0.0, -2.5, 1.5}, {2.0, -4.0, 2.5, -0.5}};
  return {{2.0 / 3.0, 0.0, -1.0, 0.5}, {4.0 / 3.0, -2.0, 1.0, -1.0 / 6.0}};
}

double axis_weight(const LatticeKernel& kernel, double d) noexcept {
  if (!is_piecewise(kernel.kind)) {
    const double t = d / kernel.sigma;
    return std::abs(d) <= kernel.support_radius() ? std::exp(-0.5 * t * t) : 0.0;
  }
  const double t = std::abs(d) / (2 * kernel.sigma);
  if (!(t < 2)) return 0.0;
  const KernelPieces pieces = pieces_of(kernel.kind);
  const std::array<double, 4>& c = t < 1 ? pieces.inner : pieces.outer;
  return c[0] + t * (c[1] + t * (c[2] + t * c[3]));
}

double axis_mass(const LatticeKernel& kernel) noexcept {
  return is_piecewise(kernel.kind) ? 2 * kernel.sigma
                                   : std::sqrt(2 * std::numbers::pi) * kernel.sigma;
}

double overshoot_of(const LatticeKernel& kernel, bool is_whole) noexcept {
  if (kernel.kind != LatticeKernelKind::kCatmullRom) return 0.0;
  // Weights w of sum 1 keep a mean within the range of what they weigh, widened by the sum of those
  // that are negative, (sum |w| - 1) / 2. Along one axis sum |w| is at most 1.25 (half-way between
  // two samples, at the faces 1.26, widened kernels 1.34); among samples that are missing as they
  // like, the sum of all is at least 0.48 of what it would be.
  constexpr double kAlongAxis = 1.34;
  constexpr double kLeastShare = 0.48;
  const double in_space = kAlongAxis * kAlongAxis * kAlongAxis;
  return (is_whole ? in_space - 1 : in_space / kLeastShare - 1) / 2;
}

double face_reach(const LatticeKernel& kernel) noexcept {
  // Half exists on the face, and from there the share falls by its slope there: of a Gaussian's
  // integral 0.4 / sigma, of a B-spline's 0.37 / sigma. Catmull-Rom's falls by 0.62 / sigma, but
  // near an edge up to 1.14 of all weights exist along each of the other axes.
  return (kernel.kind == LatticeKernelKind::kCatmullRom ? 0.24 : 0.06) * kernel.sigma;
}

}  // namespace data
}  // namespace ovoid
