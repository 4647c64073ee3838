// SPDX-License-Identifier: Apache-2.0
// --hyperslice and how it is taken.
#pragma once

#include <optional>

#include "flags.h"
#include "ovoid/hyperslice.h"

namespace ovoid::cli {

struct SliceFlags {
  std::optional<Hyperplane> plane;
  SliceMethod method = SliceMethod::kInterpolated;
  std::optional<LatticeKind> lattice;
  double spacing = 1.0;
};

void add_slice_flags(Flags& flags, SliceFlags* slice);
// Throws UsageError for flags that say how a slice is taken where none is.
void check_slice_flags(const Flags& flags, const SliceFlags& slice);

}  // namespace ovoid::cli
