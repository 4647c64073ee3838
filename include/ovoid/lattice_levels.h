// SPDX-License-Identifier: Apache-2.0
// A lattice's samples as few kernels on finer and coarser lattices: what fit_lattice() (fit.h)
// makes of a scan, and what a lattice file keeps of it. docs/numerics.md, "Levels of a scan".
#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>
#include <vector>

#include "ovoid/export.h"
#include "ovoid/lattice.h"

namespace OVOID_API ovoid {

// The kernels of one level. The level has a node for each block of 2^level samples along each axis,
// in the block's middle; the last blocks may hang over the lattice.
struct LatticeLevel {
  std::vector<std::uint32_t> nodes;   // rising; (k * m_y + j) * m_x + i, see LatticeLevels::nodes()
  std::vector<std::int32_t> weights;  // as many, in LatticeLevels::step_of() of the level; not 0
};

// sample(x) = offset + sum over levels l and nodes p of weight step_of(l) B((x - p) / 2^l), then
// rounded to a whole number, if samples are `whole`, and clamped to [least, greatest]; NaN, where
// it is missing. B is the product of a profile along each axis: the Gaussian of sigma kSigma less
// its tangent over the square of the distance at the end of its support, kReach.
struct LatticeLevels {
  static constexpr double kSigma = 0.6, kReach = 1.98;  // blocks
  static constexpr int kMostLevels = 16;

  Index3 dims{0, 0, 0};  // of the samples
  double offset = 0;     // of what has no kernels: the background
  double least = 0, greatest = 0;
  bool whole = false;                // samples are those of a scanner
  double step = 1;                   // > 0: what a weight of 1 is worth on level 0
  std::vector<LatticeLevel> levels;  // [0] is the finest; at most kMostLevels
  // From the first sample on, in turn: how many are there, and how many behind them are missing.
  // Only the first number may be 0. Empty where none is missing, as of those of a scanner.
  std::vector<std::uint32_t> holes;

  // Nodes along x, y, z.
  Index3 nodes(int level) const noexcept;
  // step / 2^(3 level / 2): an error of half a step weighs the same on every level.
  double step_of(int level) const noexcept;
  std::int64_t num_kernels() const noexcept;
};

// The samples, [dims[2]][dims[1]][dims[0]]; the same bytes for any number of threads. Throws Error:
// kInvalidArgument that names the member that is not as said above, kCancelled. `progress` is told
// fractions in [0, 1], not decreasing. Cost: some thirty operations per sample.
std::vector<float> samples_of(const LatticeLevels& levels, int threads = 0,
                              const std::stop_token& stop = {},
                              const std::function<void(double fraction)>& progress = {});

}  // namespace ovoid
