// SPDX-License-Identifier: Apache-2.0
// The weights of a lattice's kernel along one axis, docs/numerics.md, "The kernel": what model,
// view and the fast back ends know of them. The reference back end has its own.
#pragma once

#include <array>

#include "ovoid/kernels.h"

namespace ovoid::data {

// The kinds of one size are cubic polynomials of t = |d| / unit, `inner` for t < 1 and `outer` for
// 1 <= t < 2: coefficients of t^0, t^1, t^2, t^3. unit = 2 sigma: one spacing.
struct KernelPieces {
  std::array<double, 4> inner;
  std::array<double, 4> outer;
};
bool is_piecewise(LatticeKernelKind kind) noexcept;
KernelPieces pieces_of(LatticeKernelKind kind) noexcept;  // of kinds that are piecewise

// At the distance d from a sample, in the units of the kernel's sigma; 0 beyond the support. On the
// cut-off of a Gaussian itself: the whole weight.
double axis_weight(const LatticeKernel& kernel, double d) noexcept;

// The integral of axis_weight() over an endless line: what the Gaussian's is without a cut-off.
double axis_mass(const LatticeKernel& kernel) noexcept;

// A normalized field stays within its samples' range, widened on both sides by this share of it: 0
// where weights are never negative. `is_whole`: no sample in reach is missing.
double overshoot_of(const LatticeKernel& kernel, bool is_whole) noexcept;

// How far beyond the faces of the outermost cells 0.48 of all weights may exist, in the units of
// the kernel's sigma, for each unit by which it is widened.
double face_reach(const LatticeKernel& kernel) noexcept;

}  // namespace ovoid::data
