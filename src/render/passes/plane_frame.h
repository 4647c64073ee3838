// SPDX-License-Identifier: Apache-2.0
// A picture of the volume with a value plane in it (docs/numerics.md, "Value plane").
#pragma once

#include "render/field_renderer.h"

namespace ovoid {

// As ValuePlane says. Modes kComposite and kIsosurface. hooks.tile_done is called once, with the
// whole picture; progress goes on through all parts. The profile's counts and stages are sums over
// the parts. Throws as Renderer::render(); Error: kInvalidArgument for a normal that is zero or not
// finite, an offset that is not finite, and more than kMaxClipPlanes - 1 clip planes; kUnsupported
// for other modes, for the greatest, mean or integrated value of a half is nothing that an opaque
// plane could stand before. Cost: one sheet of samples, one to four per pixel; and the halves that
// can be seen: what is behind the plane is not drawn if it covers all that would be.
Frame draw_with_plane(FieldRenderer& renderer, const DrawnFields& fields, const ValuePlane& plane,
                      const Camera& camera, const RenderOptions& options, const RenderHooks& hooks);

}  // namespace ovoid
