// SPDX-License-Identifier: Apache-2.0
// Pictures of several volumes, each of its own, as one (docs/numerics.md, "Several volumes").
#pragma once

#include "ovoid/image.h"
#include "ovoid/render_options.h"
#include "ovoid/renderer.h"

namespace ovoid {

// Colours and opacities add, and may exceed 1; the depths are those of the nearer picture. Both
// have the same size.
void add_picture(const Image& other, Image& sum);

// From a sum to a picture: what exceeds 1 is cut off, or where volumes are averaged, the colour is
// the mean of theirs in proportion to their opacities.
void finish_sum(Mixing mixing, Image& sum);

// What was counted and timed for another picture joins a profile.
void add_work(const FrameProfile& other, FrameProfile& sum);

}  // namespace ovoid
