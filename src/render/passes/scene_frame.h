// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/scene.h"
#include "render/field_renderer.h"

namespace ovoid {

// Renderer::render(): finds out what of a scene is drawn by which pass, and puts it together.
Frame draw_scene(FieldRenderer& renderer, const Scene& scene, const Camera& camera,
                 const RenderOptions& options, const RenderHooks& hooks);

}  // namespace ovoid
