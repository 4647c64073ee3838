// SPDX-License-Identifier: Apache-2.0
// The values that a lattice has in a frame: how its sums are formed, where its samples lie. Every
// back end but the reference reads them here.
#pragma once

#include "ovoid/field.h"
#include "render/shared/device_layout.h"
#include "render/shared/view_values.h"

namespace ovoid {

// How the lattice's field is worked out in a frame.
struct LatticeTraits {
  bool is_sum = false;
  bool is_piecewise = false;      // the kernel is made of polynomials
  bool takes_means = false;       // of slabs
  bool has_four_taps = true;      // the kernel reaches four samples along an axis; normalized, mid
  bool corrects_gradient = true;  // constant on ramps (docs/numerics.md, "Gradients")
  bool may_have_nodes = false;    // some sheets may be sampled at nodes
};

LatticeTraits lattice_traits(const LatticeField& field, const FrameTraits& frame,
                             const RenderOptions& options);

device::LatticeConstants lattice_constants(const LatticeField& field, const view::LatticePlan& plan,
                                           const LatticeTraits& traits);

}  // namespace ovoid
