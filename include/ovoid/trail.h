// SPDX-License-Identifier: Apache-2.0
// What is drawn behind a field that moves.
#pragma once

#include <vector>

#include "ovoid/export.h"
#include "ovoid/field.h"
#include "ovoid/kernel_field.h"
#include "ovoid/transfer_function.h"

namespace OVOID_API ovoid {

// What was in a field some time ago ("motion blur"), drawn with it sheet by sheet: behind what the
// field shows on a sheet comes what the trail shows there, so that nothing of it is seen through a
// nearer surface. It has colours and opacities of its own and takes no light, nor opacity by the
// gradient.
struct Trail {
  LatticeField field;  // on the lattice of the field that it is drawn with: trail_before()
  TransferFunction transfer_function;
  // Of a kernel field, in place of `field`: the trail is their mean (docs/numerics.md, "With a
  // trail of kernel sets"), kernel_trail_before(). All alike: sums, of which there is one, or
  // normalized; with an attribute of its own for the colours, or without. Shares are divided by
  // their sum.
  std::vector<KernelMoment> moments{};
};

}  // namespace ovoid
