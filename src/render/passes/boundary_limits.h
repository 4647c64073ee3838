// SPDX-License-Identifier: Apache-2.0
// Where each pixel's ray is within a mesh (docs/numerics.md, "Meshes end at their surface").
#pragma once

#include <stop_token>

#include "ovoid/camera.h"
#include "ovoid/depth_limits.h"
#include "ovoid/look.h"
#include "ovoid/render_options.h"
#include "ovoid/scene.h"
#include "view/plan/light_volume.h"

namespace ovoid {

// Limits for a field's frame: any number of times in and out of the mesh whose surface this is,
// several pieces, holes, the eye inside; and how much of the pixel the mesh covers. `walls.opacity`
// > 0: the surface is seen, too, each layer this opaque, as Volume::walls says; a flat cell is a
// wall and bounds nothing. `light`: that arrives; null: all of it. Throws Error: kInvalidArgument,
// kCancelled, kOutOfMemory. Cost: in proportion to the triangles and the pixels that they cover.
DepthLimits boundary_limits(const Surface& surface, const Camera& camera, const Look& look,
                            const SurfaceStyle& walls, const RenderOptions& options,
                            int threads = 0, std::stop_token stop = {},
                            const view::LightVolume* light = nullptr);

}  // namespace ovoid
