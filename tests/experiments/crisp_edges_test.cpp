// SPDX-License-Identifier: Apache-2.0
// Classification after reconstruction keeps outlines crisp under zoom; before it, they blur.
#include "experiments/crisp_edges.h"

#include <gtest/gtest.h>

namespace ovoid::experiments {
namespace crisp_edges_test {

// All or nothing between two neighbouring pixels: 10 to 90 % of a straight line between them is 0.8
// pixels. The box's first and last layers are rounder than the others and end a few pixels further
// in at zoom 16, where they hold a tenth of the opacity: bound 1. Fails if a value is classified
// before it is reconstructed, or if colours are interpolated afterwards.
TEST(CrispEdges, StayAPixelWideUnderZoom) {
  for (const double zoom : {1.0, 2.0, 4.0, 8.0, 16.0}) {
    EXPECT_LE(measure_edge(zoom, 64).post_px, 1.0) << zoom;
  }
}

// The step's profile is that of the interpolating spline: 0.74 spacings from 10 to 90 %; 16 layers
// of it absorb 1 - (1 - 0.15 e)^16, which is steeper at its upper end: 0.67.
TEST(CrispEdges, GrowWithZoomInTheControl) {
  for (const double zoom : {4.0, 8.0, 16.0}) {
    const double width = measure_edge(zoom, 64).pre_px / zoom;
    EXPECT_GT(width, 0.6) << zoom;
    EXPECT_LT(width, 0.8) << zoom;
  }
}

}  // namespace crisp_edges_test
}  // namespace ovoid::experiments
