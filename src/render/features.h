// SPDX-License-Identifier: Apache-2.0
// What each back end draws of a scene: the one place that says so (back_end_features()).
#pragma once

#include "ovoid/renderer.h"

namespace ovoid {

struct FrameJob;

// Rows of the table, in its order.
enum class Feature {
  kLattices,
  kKernelSets,
  kDepthLimits,
  kParts,
  kLightVolume,
  kTrailsOfLattices,
  kTrailsOfKernelSets,
  kSeveralVolumes,
  kSeveralIsosurfaces,
  kTransferFunction2D,
  kLatticeSheets,
  kHalfSheets
};

// `by`: not kAuto.
bool draws(Backend by, Feature feature);

// Throws Error(kUnsupported) that names the first of a frame's features that the back end does not
// draw. Sheets are not looked at: what has no place for them is drawn on others.
void require_features(Backend by, const FrameJob& job);

}  // namespace ovoid
