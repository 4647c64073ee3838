// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "drawing.h"
#include "ovoid/renderer.h"
#include "session.h"

namespace ovoid::cli {

// The frame that would be drawn.
struct DryRun {
  const Scene& scene;
  const Camera& camera;
  RenderOptions options;
  RendererSetup setup;
  std::string output;  // as given
};

// What the frame will cost in time and memory, as rows for people. How many samples it has is
// counted on a picture of a quarter of its width and height, how long one takes is measured on an
// upright strip through its middle, an eighth of it. Takes up to half as long as the frame.
std::string predict(const DryRun& run, Session& session);

}  // namespace ovoid::cli
