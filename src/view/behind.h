// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/field.h"
#include "ovoid/look.h"

namespace ovoid::view {

// A second field of a frame, on the lattice of the first: behind what that shows on a sheet comes
// what this shows there, composited, without light.
struct Behind {
  const LatticeField* field = nullptr;
  Look look;
};

}  // namespace ovoid::view
