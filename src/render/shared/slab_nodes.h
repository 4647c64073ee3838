// SPDX-License-Identifier: Apache-2.0
// Where on a slab the field of a lattice is taken for its mean.
#pragma once

#include <array>

#include "ovoid/field.h"
#include "view/view_lattice.h"

namespace ovoid {

// Gauss-Legendre nodes over a slab: position in sheets from the middle, and weight (sum 1).
struct SlabNode {
  float offset = 0;
  float weight = 1;
};

inline constexpr int kMaxSlabNodes = 32;

struct SlabNodes {
  std::array<SlabNode, kMaxSlabNodes> nodes{};
  int count = 1;  // 1: the middle alone
};

// Enough of them for the mean to err by less than the agreement tier allows.
SlabNodes slab_nodes(const LatticeField& field, const view::ViewLattice& lattice);

}  // namespace ovoid
