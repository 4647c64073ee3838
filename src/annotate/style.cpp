// SPDX-License-Identifier: Apache-2.0
#include "ovoid/annotate.h"

namespace ovoid {

MarkStyle mark_style_on(const double* background) {
  MarkStyle style;
  if (background == nullptr) return style;
  style.halo_opacity = 0.75;
  style.halo_size = 0.13;
  // Luma of Rec. 709 on encoded components; the half is where black and white read alike.
  if (0.2126 * background[0] + 0.7152 * background[1] + 0.0722 * background[2] > 0.5) {
    style.ink = {0.08, 0.09, 0.11};
    style.halo = {1, 1, 1};
  }
  return style;
}

}  // namespace ovoid
