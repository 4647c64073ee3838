// SPDX-License-Identifier: Apache-2.0
// Where to look from, and how near, so that what a scene shows fills the picture.
#pragma once

#include <vector>

#include "ovoid/camera.h"
#include "ovoid/dataset.h"
#include "ovoid/export.h"
#include "ovoid/field.h"
#include "ovoid/math.h"
#include "ovoid/render_options.h"
#include "ovoid/scene.h"

namespace OVOID_API ovoid {

// From where a first picture is taken; the whole of `bounds`, of what is left of the field, is in
// sight. A patient faces the viewer ("anterior"): LPS and RAS data, but for lattices whose spacing
// is 1, which is often said of what is no patient. What is flat, one side under a quarter of the
// next, is seen face on, flat ground from above ("+z"). Everything else stands upright on z and is
// seen from the front (of data of no patient: from -y), a little from the right and above
// ("three-quarter"), or where that side is longer, more from the right ("three-quarter-side").
// Throws as default_camera().
Camera first_camera(const Field& field, const Bounds3& bounds, Space space = Space::kNone,
                    double aspect = 1.0);

struct Framing {
  double aspect = 1.0;  // width / height of the picture
  // Share of the picture that is filled, along the side where it is filled most; in (0, 1].
  double fill = 0.9;
  // Whatever way the camera is turned around its focal point afterwards, all stays in sight.
  bool is_for_turning = false;
  std::vector<ClipPlane> clip_planes;  // as in RenderOptions: what they cut away is not looked for
};

// The camera, moved but not turned, so that what a scene shows fills the picture: of its volumes
// what their looks show, their trails, and of a mesh whose walls are seen (and that has no trail)
// all of its boundary. Points show all, whatever the look makes of their values; where the look
// shows nothing, what slices show counts.
// What is as faint as a twentieth of the most opaque is passed over, and so are specks: a
// thousandth of what shows, at each border. A trail is fainter than what leaves it, so both are
// judged each by itself; what is under 2 % opaque of a trail does not count.
// The focal point is in the middle of what shows;
// `parallel_scale` is set for both projections. If nothing shows, the camera as it is. The same on
// all machines: found by adding up the opacity of some hundred thousand samples, no picture is
// drawn. Cost: some ten milliseconds. Throws Error(kInvalidArgument) for an invalid scene, camera
// or framing, and what the field's source throws.
Camera framed(Camera camera, const Scene& scene, const Framing& framing = {});

}  // namespace ovoid
