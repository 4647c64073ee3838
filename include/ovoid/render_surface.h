// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/camera.h"
#include "ovoid/export.h"
#include "ovoid/look.h"
#include "ovoid/renderer.h"
#include "ovoid/surface.h"

namespace OVOID_API ovoid {

struct SurfaceStyle {
  double opacity = 1;        // of each layer, in (0, 1]
  bool shows_edges = false;  // of the cells' faces, as dark lines
};

// A picture of the surface: its layers front to back, in the colours of the look (its
// color_function, where it has one), lit by the look's light and material if it says so; classified
// and lit exactly at each pixel. Outlines are smooth: four places of a pixel are looked at. Depth
// is where opacity first reaches 1/2, the front depth where it first is seen. Of the options these
// count: size, clip_planes, opaque_at. The look's opacities, its mode and unit distance do not.
// `threads` 0: one per hardware thread. The same bytes for any number. Throws Error:
// kInvalidArgument, kCancelled; kOutOfMemory. Cost: in proportion to the triangles, and the pixels
// they cover.
Frame render_surface(const Surface& surface, const Camera& camera, const Look& look,
                     const SurfaceStyle& style = {}, const RenderOptions& options = {},
                     int threads = 0, const RenderHooks& hooks = {});

}  // namespace ovoid
