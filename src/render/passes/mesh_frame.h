// SPDX-License-Identifier: Apache-2.0
// A picture of a mesh: its field, which ends at its boundary, and the boundary itself.
#pragma once

#include <memory>

#include "render/field_renderer.h"

namespace ovoid {

// The options' limits and those of a boundary together. Limits of the options are for walls that
// are not seen. `light`: that arrives at walls; null: all of it. Throws as boundary_limits().
std::shared_ptr<const DepthLimits> limits_within(const Surface& boundary, const SurfaceStyle& walls,
                                                 const Camera& camera, const Look& look,
                                                 const RenderOptions& options, int threads,
                                                 const RenderHooks& hooks,
                                                 const view::LightVolume* light = nullptr);

// As Volume::boundary and Volume::walls say. Throws as Renderer::render(). Cost: the field's frame,
// and that of boundary_limits().
Frame draw_mesh(FieldRenderer& renderer, const DrawnFields& fields, const Surface& boundary,
                const SurfaceStyle& walls, const Camera& camera, const RenderOptions& options,
                const RenderHooks& hooks);

}  // namespace ovoid
