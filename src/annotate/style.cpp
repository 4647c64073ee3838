// SPDX-License-Identifier: Apache-2.0
#include "ovoid/annotate.h"

namespace ovoid {

MarkStyle mark_style_on(const std::optional<Rgb>& background) {
  MarkStyle style;
  if (!background) return style;
  style.halo_opacity = 0.75;
  style.halo_size = 0.13;
  // Luma of Rec. 709 on encoded components; the half is where black and white read alike.
  const auto [red, green, blue] = *background;
  if (0.2126 * red + 0.7152 * green + 0.0722 * blue > 0.5) {
    style.ink = {0.08, 0.09, 0.11};
    style.halo = {1, 1, 1};
  }
  return style;
}

}  // namespace ovoid
