// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "model/lattice/line_solver.h"
#include "model/lattice/prefilter.h"

namespace ovoid::model {

// Lanes of a pass along z: 512 samples deep they fill a quarter of a second-level cache.
inline constexpr std::int64_t kLanesAlongZ = 128;

// Samples per task.
inline constexpr std::int64_t kGrainSamples = std::int64_t{1} << 16;

// The prefilter's first two axes.
class SliceFilter {
 public:
  SliceFilter(const Index3& dims, const PrefilterOptions& options);

  // Filters dims[0] * dims[1] samples in place. From many threads.
  void apply(float* slice) const;

 private:
  void solve_along_x(float* slice) const;

  LineSolver along_x_;
  LineSolver along_y_;
};

}  // namespace ovoid::model
