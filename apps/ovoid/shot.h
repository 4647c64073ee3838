// SPDX-License-Identifier: Apache-2.0
// What stands between data that are ready and their picture: the look, the camera, what is cut
// away. `render` and the Python module draw by it.
#pragma once

#include <optional>
#include <string>

#include "drawing.h"

namespace ovoid::cli {

struct Shot {
  Look look;
  Described described;  // with the box that is left
  SurfaceStyle walls{0, false};
  std::optional<PointStyle> points;
  Camera camera;  // aim_camera()
};

// As the flags say, but for the camera; the crop's clip planes are added to the options of
// `drawing`. Throws Error.
Shot make_shot(const Subject& subject, DrawingFlags* drawing, Session& session);

// The camera has what shows in sight, that of the trail (null: none) included. Throws Error.
void aim_camera(Shot* shot, const Subject& subject, const DrawingFlags& drawing,
                const Trail* trail);

// What a frame of it shows, without a trail. All three outlive the result.
FrameSubject frame_subject(const Subject& subject, const Shot& shot, const DrawingFlags& drawing);

// A picture without anything in it is seldom what was meant: tells why there may be nothing.
void note_if_empty(const Image& image, const Shot& shot, const ValueRange& values,
                   Session& session);

// Turns an x-ray's integrals into colours, over which the look is spread anew; other pictures stay
// as they are.
void color_for_eyes(Image& image, Look& look, const LookFlags& flags, Session& session);

}  // namespace ovoid::cli
