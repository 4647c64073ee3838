// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/field.h"
#include "ovoid/look.h"
#include "ovoid/render_options.h"

namespace ovoid::view {

// The trail of a frame, on the lattice of the frame's field: behind what the field shows on a sheet
// comes what the trail shows there, composited, without light.
struct TrailView {
  const LatticeField* field = nullptr;
  Look look;
  RenderOptions options;
};

}  // namespace ovoid::view
