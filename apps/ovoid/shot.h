// SPDX-License-Identifier: Apache-2.0
// What stands between data that are ready and their picture: the look, the camera, what is cut
// away. `render` and the Python module draw by it.
#pragma once

#include <string>

#include "drawing.h"

namespace ovoid::cli {

struct Shot {
  Scene scene;
  Described described;  // with the box that is left
  Camera camera;        // aim_camera()

  Look& look() { return scene.volumes.front().look; }
  const Look& look() const { return scene.volumes.front().look; }
};

// As the flags say, but for the trail and the camera; the crop's clip planes are added to the
// options of `drawing`. Throws Error.
Shot make_shot(const Subject& subject, DrawingFlags* drawing, Session& session);

// The camera has what shows in sight, that of the trail included. Throws Error.
void aim_camera(Shot* shot, const DrawingFlags& drawing);

// A picture without anything in it is seldom what was meant: tells why there may be nothing.
void note_if_empty(const Image& image, const Shot& shot, const ValueRange& values,
                   Session& session);

// Turns an x-ray's integrals into colours, over which the look is spread anew; other pictures stay
// as they are.
void color_for_eyes(Image& image, Look& look, const LookFlags& flags, Session& session);

}  // namespace ovoid::cli
