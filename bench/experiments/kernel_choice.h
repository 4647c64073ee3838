// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "experiments/fields.h"

namespace ovoid::experiments {

// How well a field of samples stands for the function they were taken from. Lengths in spacings.
struct KernelErrors {
  double rms = 0;            // Marschner-Lobb, 40^3, of the range, at random places inside
  double greatest = 0;       // the same, greatest
  double exact_deg = 0;      // mean angle between the field's own gradient and the function's
  double corrected_deg = 0;  // the same for the corrected gradient
  double central_deg = 0;    // the same for differences over +- one spacing
  double quarter = 0;        // amplitude left of a wave of 0.25 cycles per sample along one axis
  double half = 0;           // the same at the band limit, 0.5
  double ripple = 0;         // of a constant: greatest less least, of the mean
  double ramp_deg = 0;  // greatest angle by which the exact gradient of a linear function is wrong
  double corrected_ramp_deg = 0;
  double overshoot = 0;  // beyond the values on either side of a step edge, of its height
};

// `num_points` random places for each measure that uses them.
KernelErrors measure_trilinear(int num_points);
KernelErrors measure_kernel(const KernelChoice& choice, int num_points);

}  // namespace ovoid::experiments
