// SPDX-License-Identifier: Apache-2.0
// The limits of vtkPiecewiseFunction's midpoint and sharpness (docs/looks.md, "Opacity").
#pragma once

namespace ovoid::view {

// A midpoint at an end would divide by zero: it acts as the nearest of these.
inline constexpr double kMinMidpoint = 0.00001;
inline constexpr double kMaxMidpoint = 0.99999;

// Below the first a segment is straight (but for its midpoint), above the second a step at its
// midpoint.
inline constexpr double kLinearSharpness = 0.01;
inline constexpr double kStepSharpness = 0.99;

}  // namespace ovoid::view
