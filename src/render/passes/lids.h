// SPDX-License-Identifier: Apache-2.0
// What closes a mesh that clip planes have cut open: its field on the cut.
#pragma once

#include <optional>

#include "ovoid/surface.h"
#include "render/field_renderer.h"
#include "render/passes/surface_frame.h"

namespace ovoid {

// None: no ray comes into what is left of the mesh through a cut. The profile of the frame that
// drew them is added to `profile`. Throws what Renderer::render() throws.
std::optional<Lids> make_lids(FieldRenderer& renderer, const DrawnFields& fields,
                              const Surface& surface, const Camera& camera,
                              const RenderOptions& options, const RenderHooks& hooks,
                              FrameProfile* profile);

}  // namespace ovoid
