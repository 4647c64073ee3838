// SPDX-License-Identifier: Apache-2.0
// Round numbers along a scale, and numbers as text.
#pragma once

#include <string>
#include <vector>

#include "ovoid/transfer_function.h"

namespace ovoid::annotate {

struct Tick {
  double value = 0;
  std::string label;
};

// Values from lo to hi (finite, lo <= hi) along a line: 0 at lo, 1 at hi.
class TickScale {
 public:
  // A logarithmic scale needs lo > 0; without it the scale is linear.
  TickScale(ValueScale kind, double lo, double hi, double linear_width = 1.0);

  double place(double value) const;  // in [0, 1] for values from lo to hi; 1/2 if lo == hi
  double value(double place) const;  // its inverse
  double lo() const noexcept { return lo_; }
  double hi() const noexcept { return hi_; }
  bool is_linear() const noexcept { return kind_ == ValueScale::kLinear; }

  // At most `most` (>= 2) round values: multiples of 1, 2 or 5 times a power of ten; on a
  // logarithmic scale powers of ten, or 1, 2 and 5 times such where there are few. Labels differ
  // from each other. Where the doubles between lo and hi are too few for round values: none.
  std::vector<Tick> ticks(int most) const;

 private:
  double warp(double value) const;
  double unwarp(double warped) const;
  std::vector<Tick> log_ticks(int most) const;
  std::vector<Tick> symlog_ticks(int most) const;

  ValueScale kind_;
  double lo_, hi_, linear_width_;
  double warped_lo_, warped_hi_;
};

// Round values on a linear scale, as above.
std::vector<Tick> linear_ticks(double lo, double hi, int most);

// The greatest of 1, 2, 5 times a power of ten that is at most `limit` (> 0, normal).
double round_below(double limit);

// `value` to the decimals that tell values `resolution` apart (> 0; 0: as many as it has), without
// trailing zeros; with an exponent where that is shorter and the plain number has over 6 digits.
std::string number_text(double value, double resolution = 0);

}  // namespace ovoid::annotate
