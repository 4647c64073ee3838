// SPDX-License-Identifier: Apache-2.0
// A picture of a surface, with lids where it has been cut open.
#pragma once

#include <cstdint>
#include <vector>

#include "ovoid/camera.h"
#include "ovoid/look.h"
#include "ovoid/render_options.h"
#include "ovoid/renderer.h"
#include "ovoid/scene.h"
#include "ovoid/surface.h"
#include "view/plan/light_volume.h"

namespace ovoid {

// What closes a cut, seen in some pixels.
struct Lids {
  std::vector<std::uint8_t> covered;  // [height, width] bit i: the lid is in the pixel's place i
  std::vector<float> depth;           // [height, width] where it is
  Image colors;                       // premultiplied; transparent: there is none after all
};

struct SurfaceSurroundings {
  const Lids* lids = nullptr;                // null: none
  const view::LightVolume* light = nullptr;  // that arrives; null: all of it
};

// The surface's layers front to back, in the colours of the look (its color_function, where it has
// one), lit by the look's light and material if it says so; classified and lit exactly at each
// pixel. Outlines are smooth: four places of a pixel are looked at. Of the options these count:
// size, clip_planes, opaque_at, part. The look's opacities, its mode and unit distance do not.
// `threads` 0: one per hardware thread. The same bytes for any number. Throws Error:
// kInvalidArgument, also for an opacity out of (0, 1]; kCancelled; kOutOfMemory. Cost: in
// proportion to the triangles, and the pixels they cover.
Frame paint_surface(const Surface& surface, const Camera& camera, const Look& look,
                    const SurfaceStyle& style = {}, const RenderOptions& options = {},
                    int threads = 0, const RenderHooks& hooks = {},
                    const SurfaceSurroundings& around = {});

}  // namespace ovoid
