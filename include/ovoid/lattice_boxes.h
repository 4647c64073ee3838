// SPDX-License-Identifier: Apache-2.0
// A lattice's samples as boxes in which values rise evenly: what simplify_lattice() (simplify.h)
// makes of a scan, and what a lattice file keeps of it. docs/numerics.md, "Boxes of a scan".
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <stop_token>
#include <vector>

#include "ovoid/export.h"
#include "ovoid/lattice.h"

namespace OVOID_API ovoid {

// Samples [begin, begin + size) along x, y, z, where `begin` follows from the boxes before. The
// value of the sample (i, j, k) from the first corner on, in steps above the least:
//
//   first + rise[0] i / (size[0] - 1) + rise[1] j / (size[1] - 1) + rise[2] k / (size[2] - 1)
//
// without the terms of axes of one sample.
struct LatticeBox {
  static constexpr std::int32_t kMissing = std::numeric_limits<std::int32_t>::min();

  std::int64_t gap = 0;  // samples in no box before it, since the first sample of the one before
  std::array<std::int32_t, 3> size{1, 1, 1};  // >= 1
  std::int32_t first = 0;                     // kMissing: none of its samples has a value
  std::array<std::int32_t, 3> rise{0, 0, 0};

  bool operator==(const LatticeBox&) const = default;
};

// sample = least + step * (what its box says), rounded to a whole number if samples are `whole`,
// and clamped to [least, greatest]; `background` where there is no box. Boxes do not overlap. They
// come in the order of their first samples, x fastest; of the samples in between, those count to
// the gap that lie in no box before.
struct LatticeBoxes {
  Index3 dims{0, 0, 0};            // fewer than 2^32 samples
  double least = 0, greatest = 0;  // like the background floats
  double background = 0;
  bool whole = false;  // samples are those of a scanner
  double step = 1;     // > 0
  std::vector<LatticeBox> boxes;
};

// The samples, [dims[2]][dims[1]][dims[0]]; missing ones, of which `whole` samples have none, are
// NaN. Throws Error: kInvalidArgument that names the member or box that is not as said above,
// kOutOfMemory, kCancelled. `progress` is told fractions
// in [0, 1], not decreasing. Cost: some nanoseconds per sample.
std::vector<float> samples_of(const LatticeBoxes& boxes, const std::stop_token& stop = {},
                              const std::function<void(double fraction)>& progress = {});

}  // namespace ovoid
