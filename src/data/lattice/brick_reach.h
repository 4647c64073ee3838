// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/lattice.h"

namespace ovoid::data {

// Samples lo <= (i, j, k) < hi, k the layer.
struct SampleRange {
  Index3 lo, hi;
};

// The samples of a brick of so many cells per axis.
SampleRange samples_in_brick(const LatticeGeometry& geometry, const Index3& brick,
                             int edge) noexcept;

// The samples that kernels of that support radius (index units) bring to a brick's cells, their far
// end included; see make_brick_table(). Of body-centred lattices whole axis vectors are counted:
// somewhat more than need be. At least one sample.
SampleRange samples_in_reach(const LatticeGeometry& geometry, const Index3& brick, int edge,
                             double reach) noexcept;

}  // namespace ovoid::data
