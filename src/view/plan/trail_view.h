// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "ovoid/field.h"
#include "ovoid/look.h"
#include "ovoid/render_options.h"

namespace ovoid::view {

// The trail of a frame: behind what the field shows on a sheet comes what the trail shows there,
// composited, without light.
struct TrailView {
  const LatticeField* field = nullptr;  // of a lattice field, on its lattice
  std::vector<KernelMoment> moments;    // of a kernel field; the shares' sum is 1
  Look look;
  RenderOptions options;
};

}  // namespace ovoid::view
