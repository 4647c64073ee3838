// SPDX-License-Identifier: Apache-2.0
// The way along which colour and opacity run between two points (ValueScale), as numbers: curves
// are straight, or shaped, in g(value) instead of in the value itself.
#pragma once

#include <cmath>
#include <limits>
#include <numbers>

#include "ovoid/transfer_function.h"

namespace ovoid::view {

// log10(1 + magnitude / width), also where the quotient is beyond the range of double.
inline double symmetric_logarithm(double magnitude, double width) {
  const double quotient = magnitude / width;
  if (std::isfinite(quotient)) return std::log1p(quotient) * std::numbers::log10e;
  return std::log10(magnitude) - std::log10(width);
}

// g(value): the value (kLinear), log10(value) (kLog), sign(value) log10(1 + |value| / linear_width)
// (kSymlog; `linear_width` > 0 is used there alone). Rises with the value. Under kLog values <= 0
// lie below everything: -infinity. NaN gives NaN.
inline double along(ValueScale scale, double linear_width, double value) {
  switch (scale) {
    case ValueScale::kLinear:
      return value;
    case ValueScale::kLog:
      if (value <= 0.0) return -std::numeric_limits<double>::infinity();
      return std::log10(value);
    case ValueScale::kSymlog:
      return std::copysign(symmetric_logarithm(std::abs(value), linear_width), value);
  }
  return value;
}

// The value whose g is `place`: undoes along() to rounding. Places beyond the range of double give
// infinity (or 0, under kLog).
inline double value_at(ValueScale scale, double linear_width, double place) {
  switch (scale) {
    case ValueScale::kLinear:
      return place;
    case ValueScale::kLog:
      return std::pow(10.0, place);
    case ValueScale::kSymlog:
      return std::copysign(linear_width * std::expm1(std::abs(place) * std::numbers::ln10), place);
  }
  return place;
}

}  // namespace ovoid::view
