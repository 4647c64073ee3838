// SPDX-License-Identifier: Apache-2.0
// Which frames have lattice sheets (docs/numerics.md, "Lattice sheets").
#pragma once

#include <optional>

#include "render/back_end.h"

namespace ovoid {

struct LatticeSheets {
  view::BasePlane base;
  double sampling_distance;
};

// Empty: the frame has image sheets. job.options has a sampling distance, that of image sheets if
// nobody asks for one (`is_distance_free`). Throws Error(kUnsupported) where RenderOptions::sheets
// insists on what cannot be.
std::optional<LatticeSheets> lattice_sheets_for(const BackEnd& back_end, const FrameJob& job,
                                                bool is_distance_free);

// Of the frame's steepest look, view::steepness_of().
double steepness_of(const FrameJob& job);

}  // namespace ovoid
