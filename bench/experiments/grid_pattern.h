// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "experiments/fields.h"
#include "ovoid/image.h"
#include "ovoid/renderer.h"

namespace ovoid::experiments {

// A surface that should be shaded smoothly, magnified: what of the lattice shows on it.
enum class SmoothSurface { kPlane, kBall };

struct GridPattern {
  double residual = 0;  // standard deviation of the brightness about what it should be, 8-bit steps
  Image image;
};

// The surface at one value of a ramp (plane) or of a distance (ball), 32^3 samples, under a
// directional light, `pixels` squared, with `pixels_per_sample`. What the brightness should be
// comes from the surface's own normal.
struct GridPatternOptions {
  SmoothSurface surface = SmoothSurface::kPlane;
  int pixels = 256;
  double pixels_per_sample = 12;
  GradientMethod gradient = GradientMethod::kCorrected;  // or exact
};
GridPattern measure_grid_pattern(const KernelChoice& choice, const GridPatternOptions& options);

}  // namespace ovoid::experiments
