// SPDX-License-Identifier: Apache-2.0
// What stands in a scene beside its field, as limits on the field's frame (docs/numerics.md,
// "Geometry").
#pragma once

#include <span>
#include <stop_token>

#include "ovoid/camera.h"
#include "ovoid/depth_limits.h"
#include "ovoid/look.h"
#include "ovoid/render_options.h"
#include "ovoid/scene.h"
#include "view/plan/light_volume.h"

namespace ovoid {

// The layers of a surface, lit as `look` says; clip planes leave it whole. `light`: that arrives;
// null: all of it. Throws as boundary_limits().
DepthLimits layers_of(const Geometry& geometry, const Camera& camera, const Look& look,
                      const RenderOptions& options, int threads, const std::stop_token& stop,
                      const view::LightVolume* light);

// The limits of `options`, or else a field without limits, with layers of surfaces and slices among
// its stops: what is behind an opaque one is hidden, what is before it, field or surface, is seen
// before it. `labels`: their surfaces, and where they let the field be drawn; null: there are none.
// Throws Error(kCancelled). Cost: 28 bytes for every pixel.
DepthLimits merged_limits(std::span<const DepthLimits> layers, const DepthLimits* labels,
                          const RenderOptions& options, int threads, const std::stop_token& stop);

}  // namespace ovoid
