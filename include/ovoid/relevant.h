// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "ovoid/export.h"

namespace OVOID_API ovoid {

// Which samples of a lattice are kept where relevant ones are kept alone, as runs: those whose
// value is greater than `above`, and missing ones (NaN, infinities). All others become the
// background.
struct RelevantSamples {
  double above = 0.0;  // a value, finite
  // A value, finite, rounded and clamped to what the type can store; none: the least finite value
  // of the array in each step.
  std::optional<double> background{};
  // Keeps also what kernels of support radius 2 bring to places where the field may be greater than
  // `above`, in bricks of 4 cells and 1 beside them: then the field of samples as they are is the
  // same there, and nowhere else above it, if the background is not. So is a picture whose look
  // shows nothing up to `above`. Prefiltered fields change a little at the borders.
  bool with_reach = false;
};

}  // namespace ovoid
