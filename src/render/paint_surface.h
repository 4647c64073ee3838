// SPDX-License-Identifier: Apache-2.0
// A picture of a surface, with lids where it has been cut open.
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "ovoid/depth_limits.h"
#include "ovoid/render_surface.h"
#include "view/light_volume.h"

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

// render_surface() in surroundings.
Frame paint_surface(const Surface& surface, const Camera& camera, const Look& look,
                    const SurfaceStyle& style, const RenderOptions& options, int threads,
                    const RenderHooks& hooks, const SurfaceSurroundings& around);

// boundary_limits(), with walls under the light that arrives; null: all of it.
DepthLimits boundary_limits_in_light(const Surface& surface, const Camera& camera, const Look& look,
                                     const SurfaceStyle& walls, const RenderOptions& options,
                                     int threads, const std::stop_token& stop,
                                     const view::LightVolume* light);

}  // namespace ovoid
