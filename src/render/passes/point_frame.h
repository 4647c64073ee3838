// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/camera.h"
#include "ovoid/kernel_field.h"
#include "ovoid/look.h"
#include "ovoid/render_options.h"
#include "ovoid/renderer.h"
#include "ovoid/scene.h"

namespace ovoid {

// A picture of the kernels themselves, as PointStyle says. Depth is where half of the pixel is
// covered, the front depth where any of it is. Of the options size, clip planes and part count.
// `threads` 0: one per hardware thread. The same bytes for any number. Throws Error:
// kInvalidArgument, kCancelled, kOutOfMemory, what the source throws.
Frame paint_points(const KernelField& field, const Camera& camera, const Look& look,
                   const PointStyle& style = {}, const RenderOptions& options = {}, int threads = 0,
                   const RenderHooks& hooks = {});

}  // namespace ovoid
