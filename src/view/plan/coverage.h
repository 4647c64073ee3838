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

// The same of a frame with a trail, which limits do not hold for: beside what is covered is what
// the trail shows `alone`.
inline void blend_by_coverage(std::span<const float> coverage, const Image& alone, Image& image) {
  for (std::size_t i = 0; i < coverage.size(); ++i) {
    const float q = coverage[i];
    for (std::size_t c = 4 * i; c < 4 * i + 4; ++c)
      image.rgba[c] = q * image.rgba[c] + (1 - q) * alone.rgba[c];
    if (q < 0.5F) image.depth[i] = alone.depth[i];
    if (q < kLeastVisibleOpacity) image.front_depth[i] = alone.front_depth[i];
    if (!(image.rgba[4 * i + 3] >= kLeastVisibleOpacity))
      image.front_depth[i] = std::numeric_limits<float>::infinity();
  }
}

}  // namespace ovoid::view
