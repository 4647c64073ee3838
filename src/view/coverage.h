// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <span>

#include "ovoid/image.h"
#include "ovoid/look.h"

namespace ovoid::view {

// What depth limits are true of only a part of a pixel. An integral stays what it is, and so does
// the depth of what is covered, unless nothing of it is seen any more.
inline void apply_coverage(std::span<const float> coverage, Mode mode, Image& image) {
  if (mode == Mode::kXray) return;
  for (std::size_t i = 0; i < coverage.size(); ++i) {
    for (std::size_t c = 0; c < 4; ++c) image.rgba[4 * i + c] *= coverage[i];
    if (!(image.rgba[4 * i + 3] >= kLeastVisibleOpacity))
      image.front_depth[i] = std::numeric_limits<float>::infinity();
  }
}

}  // namespace ovoid::view
