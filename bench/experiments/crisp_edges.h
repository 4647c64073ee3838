// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/image.h"

namespace ovoid::experiments {

// A box with a step edge, magnified: how wide its outline is when classification comes after
// reconstruction, and when it comes before.
struct CrispEdge {
  Image post;          // samples -> field -> colour and opacity: the CPU back end
  Image pre;           // samples -> colour and opacity -> fields of them: the control
  double post_px = 0;  // from 10 to 90 % of the greatest opacity along a row through the outline
  double pre_px = 0;
};

// Zoom 1 shows a sample on every pixel.
CrispEdge measure_edge(double zoom, int pixels);

}  // namespace ovoid::experiments
