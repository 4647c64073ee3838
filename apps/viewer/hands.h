// SPDX-License-Identifier: Apache-2.0
// What the mouse does to a camera. Pixels as Projection has them; `height` is the picture's.
#pragma once

#include <string>

#include "ovoid/camera.h"
#include "projection.h"

namespace ovoid::viewer {

// The world turns with the mouse about the focal point: half a turn over the picture's height.
void orbit(Camera& camera, const Vec2& moved, double height);

// What lies at the focal plane stays under the mouse.
void pan(Camera& camera, const Vec2& moved, double height);

// About the view axis, by the angle through which the mouse went around the middle of the picture.
void roll_with(Camera& camera, const Vec2& from, const Vec2& to, const Vec2& middle);

// Comes nearer by `factor` (> 1), so that the point of the focal plane under `cursor` stays there.
// With perspective the eye moves; it stops short of a millionth of `extent`, the size of the data,
// and a million times as far.
void zoom_to(Camera& camera, double factor, const Vec2& cursor, const Vec2& size, double extent);

// Between the projections, the focal plane staying as large as it is.
void toggle_projection(Camera& camera);

}  // namespace ovoid::viewer
