// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <limits>

#include "ovoid/image.h"
#include "ovoid/look.h"

namespace ovoid {

// The modes whose pixels hold a value of the field until all of the ray has been seen.
inline bool shows_values(Mode mode) {
  return mode == Mode::kXray || mode == Mode::kMaximum || mode == Mode::kMinimum ||
         mode == Mode::kMean;
}

// What such a pixel keeps where only a part of the ray has been seen (DeepImage::Run), as `best`
// and `path` of show_value().
inline void keep_value(float best, float path, float* rgba) {
  rgba[0] = best;
  rgba[1] = path;
  rgba[2] = 0.0F;
  rgba[3] = 1.0F;
}

// What an x-ray, maximum, minimum or mean picture shows of a pixel that some sample was defined in:
// rgba, premultiplied. `best`: the greatest or least value, or the sum of value times path; `path`:
// their sum.
inline void show_value(const Look& look, float best, float path, float* rgba) {
  if (look.mode == Mode::kXray) {
    rgba[0] = rgba[1] = rgba[2] = best;
    rgba[3] = 1.0F;
    return;
  }
  const double value = look.mode == Mode::kMean ? best / path : best;
  const Rgb color = look.transfer_function.color_at(value);
  const double opacity = look.transfer_function.opacity_at(value);
  for (std::size_t c = 0; c < 3; ++c) rgba[c] = static_cast<float>(color[c] * opacity);
  rgba[3] = static_cast<float>(opacity);
}

// Its front depth: that of what it shows, if that is seen.
inline float front_depth_of_value(const float* rgba, float depth) {
  return rgba[3] >= kLeastVisibleOpacity ? depth : std::numeric_limits<float>::infinity();
}

}  // namespace ovoid
