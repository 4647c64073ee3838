// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "experiments/control_renderer.h"
#include "ovoid/image.h"
#include "ovoid/renderer.h"

namespace ovoid::experiments {

enum class TurnLook {
  kHaze,  // semi-transparent throughout, with one thin bright layer
  kHard,  // nothing, and from one value on all
};

// A turn about the y axis, with 45 degrees in the middle of the middle step: there the axis changes
// that the view is nearest to.
struct TurnOptions {
  int pixels = 96;
  int steps = 45;           // odd
  Index3 size{40, 40, 40};  // samples of the Marschner-Lobb signal
  double step_degrees = 1;
  TurnLook look = TurnLook::kHaze;
};

struct Turn {
  std::vector<double> changes;  // mean absolute difference of neighbouring pictures, 8-bit steps
  double greatest_column = 0;   // by which a picture changes if a column of pixels comes or goes
  Image before;                 // the two pictures around 45 degrees
  Image after;

  double at_switch() const { return changes[changes.size() / 2]; }
  double median() const;
  double greatest() const;
  // 1 where the step through 45 degrees is like any other; popping is far above.
  double jump() const { return at_switch() / median(); }
};

Turn turn_control(Sheets sheets, const TurnOptions& options);
Turn turn_renderer(const TurnOptions& options);  // the CPU back end, lit

// |a - b|, magnified by `gain`, on black.
Image difference(const Image& a, const Image& b, double gain);

}  // namespace ovoid::experiments
