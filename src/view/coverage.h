// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/depth_limits.h"
#include "ovoid/image.h"
#include "ovoid/look.h"

namespace ovoid::view {

// What depth limits are true of only a part of a pixel. An integral stays what it is.
inline void apply_coverage(const DepthLimits& limits, Mode mode, Image& image) {
  if (mode == Mode::kXray) return;
  for (std::size_t i = 0; i < limits.coverage.size(); ++i) {
    for (std::size_t c = 0; c < 4; ++c) image.rgba[4 * i + c] *= limits.coverage[i];
  }
}

}  // namespace ovoid::view
