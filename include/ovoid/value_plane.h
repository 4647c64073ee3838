// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/export.h"
#include "ovoid/math.h"
#include "ovoid/renderer.h"

namespace OVOID_API ovoid {

// What lies between the eye and a value plane: drawn over it, or cut away.
enum class PlaneFront { kShown, kRemoved };

// An opaque plane that shows the field itself, its colours by value, without light or opacity: the
// points with dot(normal, x) == offset (world; ClipPlane's words). `normal` need not have unit
// length, and its sign does not matter to the picture.
struct ValuePlane {
  Vec3 normal{1, 0, 0};
  double offset = 0;
  PlaneFront front = PlaneFront::kRemoved;
};

// A picture of the volume with the plane in it (docs/numerics.md, "Value plane"). A pixel holds,
// front to back: the volume in front of the plane (kShown alone), the plane's colour, opaque where
// the field is defined on it and the place lies inside all of options.clip_planes, and the volume
// behind it. The volume looks as render() draws it, cut along the plane as by a ClipPlane. In front
// is the half space that holds the eye; with parallel projection, the one from which rays come. A
// plane that no ray of the picture meets (seen edge-on, or behind the eye) has nothing in front of
// it: the frame is render()'s.
//
// The plane's colours are those of the look's transfer function, or, for fields with a colour
// attribute of their own, of its color_function, at the field's value there. Where a pixel's rays
// meet the plane, depth is the plane's unless the volume in front reaches opacity 1/2. Where the
// field is not defined on the plane and it takes both halves to reach 1/2, depth is that of the
// half behind, or, if that does not reach it by itself, the plane's. The front depth likewise.
//
// Modes kComposite and kIsosurface. The same arguments give the same bytes, whatever the number of
// threads. hooks.tile_done is called once, with the whole picture; progress goes on through all
// parts. The profile's counts and stages are sums over the parts. Throws what render() throws;
// Error: kInvalidArgument for a normal that is zero or not finite, an offset that is not finite,
// and more than kMaxClipPlanes - 1 clip planes; kUnsupported for other modes, for the greatest,
// mean or integrated value of a half is nothing that an opaque plane could stand before.
// Cost: one sheet of samples, one to four per pixel; and the halves that can be seen: what is
// behind the plane is not drawn if it covers all that would be.
Frame render_with_plane(Renderer& renderer, const Field& field, const Camera& camera,
                        const Look& look, const ValuePlane& plane,
                        const RenderOptions& options = {}, const RenderHooks& hooks = {});

}  // namespace ovoid
