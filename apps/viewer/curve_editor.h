// SPDX-License-Identifier: Apache-2.0
// Points of a curve over values, edited with the mouse: opacity by value before a histogram,
// opacity by gradient, and the colours on the strip below.
#pragma once

#include <string>
#include <vector>

#include "histogram.h"
#include "ovoid/transfer_function.h"
#include "widgets.h"

namespace ovoid::viewer {

// Where values lie from left to right.
struct ValueAxis {
  double lo = 0, hi = 1;
  ValueScale scale = ValueScale::kLinear;
  double linear_width = 1;  // of kSymlog

  double place_of(double value) const;  // 0 at lo, 1 at hi
  double value_at(double place) const;
};

// What is remembered of an editor between frames.
struct CurveEditing {
  int selected = -1;
  int dragged = -1;
};

struct CurveLook {
  float height = 140;                         // of the canvas, before the interface's scale
  const cli::Histogram* histogram = nullptr;  // drawn behind; null: none
  bool is_log_count = true;                   // heights of its bars
  bool is_magnified = false;    // low opacities get more room: height is the cube root
  std::vector<double> marks{};  // values with a line: the isovalue
};

// Click on the line or into the empty canvas: a new point, which follows the mouse. Drag: moves it,
// between its neighbours. Right click, or Delete: away with it. Items are named NAME.N by number.
// Returns whether the curve changed.
bool edit_opacities(Widgets& widgets, const std::string& name, std::vector<OpacityPoint>& points,
                    const ValueAxis& axis, const CurveLook& look, CurveEditing& editing);

// The same for the colours of a transfer function, on a strip that shows them.
bool edit_colors(Widgets& widgets, const std::string& name, TransferFunction& tf,
                 const ValueAxis& axis, CurveEditing& editing);

}  // namespace ovoid::viewer
