// SPDX-License-Identifier: Apache-2.0
// Pictures of a mesh that end where the mesh ends: its field within its boundary, and the boundary
// itself. docs/numerics.md, "Meshes end at their surface".
#pragma once

#include <stop_token>

#include "ovoid/camera.h"
#include "ovoid/depth_limits.h"
#include "ovoid/export.h"
#include "ovoid/look.h"
#include "ovoid/render_options.h"
#include "ovoid/render_surface.h"
#include "ovoid/renderer.h"
#include "ovoid/surface.h"

namespace OVOID_API ovoid {

// Where each pixel's ray is within the mesh whose surface this is, as limits for the field's frame:
// any number of times in and out, several pieces, holes, the eye inside; and how much of the pixel
// the mesh covers. Where the boundary is not closed a ray is taken to be inside up to, or from, the
// boundary that it does meet. `walls.opacity` > 0: the surface is seen, too, each layer this
// opaque, in the look's colours and light as render_surface() draws it; a flat cell is a wall and
// bounds nothing. Clip planes take walls away, and leave the mesh where it is. Throws Error:
// kInvalidArgument, kCancelled, kOutOfMemory. Cost: in proportion to the triangles and the pixels
// that they cover.
DepthLimits boundary_limits(const Surface& surface, const Camera& camera, const Look& look,
                            const SurfaceStyle& walls, const RenderOptions& options,
                            int threads = 0, std::stop_token stop = {});

// A picture of a mesh: of its field (make_kernel_field()) within its surface (make_surface()), and,
// with `walls.opacity` > 0, of the surface around it. Opaque walls hide the field, which is then
// seen on the lids that close what clip planes have cut open, without light. A surface that does
// not enclose the mesh (Surface::encloses_mesh()) leaves the field as Renderer::render() draws it,
// and is drawn, if it is to be, without the field. `options.depth_limits` must be null. Throws what
// boundary_limits() and Renderer::render() throw. Cost: theirs.
Frame render_mesh(Renderer& renderer, const Field& field, const Surface& surface,
                  const Camera& camera, const Look& look, const SurfaceStyle& walls = {},
                  const RenderOptions& options = {}, const RenderHooks& hooks = {});

}  // namespace ovoid
