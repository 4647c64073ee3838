// SPDX-License-Identifier: Apache-2.0
// The transfer function as the cpu back end reads it: colour and opacity at evenly spaced values,
// straight lines between.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "ovoid/transfer_function.h"

namespace ovoid::view {

// Where a value lies among the table's entries. Linear scales: in proportion to the value. Others:
// by the bits of a float, which taken as an integer rise with it and are straight within each
// octave: a logarithm that costs nothing, that vector code repeats exactly, and that gives every
// decade as many cells.
struct LookAxis {
  ValueScale scale = ValueScale::kLinear;
  float origin = 0.0F;           // kLinear: the value of entry 0
  std::int32_t origin_bits = 0;  // others: warped(value of entry 0)
  float cells_per_step = 1.0F;   // cells per unit of value, or per unit of warped(), > 0
  float inverse_width = 1.0F;    // kSymlog: 1 / linear_width

  static constexpr float kLeast = 1.17549435e-38F;  // kLog: what is smaller lies there, too

  // The bits: kLog of the value, kSymlog of 1 + |value| / linear_width, counted from those of 1,
  // with the value's sign.
  std::int32_t warped(float value) const noexcept {
    if (scale == ValueScale::kLog) return std::bit_cast<std::int32_t>(std::max(value, kLeast));
    const float magnitude = 1.0F + std::abs(value) * inverse_width;
    const std::int32_t bits =
        std::bit_cast<std::int32_t>(magnitude) - std::bit_cast<std::int32_t>(1.0F);
    return value < 0.0F ? -bits : bits;
  }

  // In cells from entry 0, not clamped.
  float place(float value) const noexcept {
    const float steps = scale == ValueScale::kLinear
                            ? value - origin
                            : static_cast<float>(warped(value) - origin_bits);
    return steps * cells_per_step;
  }

  double value_of_entry(double i) const noexcept;
};

// A table of kCells cells over the values where a transfer function has something to show. The
// reading rule, which vector code follows operation by operation (at() is its scalar form):
//
//   t = clamp(axis().place(value), 0, kCells);  i = int(t);  f = t - i;
//   if (step[i] >= 0) f = f >= step[i] ? 1 : 0;
//   x = x[i] + f * (x[i + 1] - x[i])
//
// Entry i stands for the value axis().value_of_entry(i). Whether the last line is fused does not
// change where the opacity is zero. Every array has kPaddedEntries floats, 64-byte aligned, the
// last entry repeated, so that x[i + 1] exists for t = kCells, too. `value` must not be NaN;
// infinities read as the ends.
//
// Coverage: from the first to the last value whose opacity is not zero, and a cell more on either
// side; where the curve does not end in zeros, to the outermost point of colours and opacities. So
// a peak 2 % of the range wide has all the cells to itself. Colours where nothing shows are not
// kept: isosurfaces take theirs from TransferFunction::color_at().
//
// Against exact evaluation: straight pieces of a linear scale agree to float rounding; at a corner
// the table errs by at most a quarter of the difference of the slopes, times a cell; a step (two
// points of one x, sharpness over 0.99, ColorSpace::kStep) is where it should be to float rounding,
// and the rest of its cell is flat, so that it errs by the slope times a cell; of several steps in
// one cell the last is kept; a feature narrower than kMinFeatureCells may be missed. Pieces along a
// logarithm err by an eighth of the second derivative times the square of a cell. Zero stays zero:
// where the curve is zero over more than a cell up to a corner and the corner included, the table
// is exactly zero, too (background that sits at the foot of a ramp costs nothing); in turn the ramp
// may start up to a cell late.
//
// Immutable; all members may be called from many threads. Cost of construction: kEntries exact
// evaluations, about 0.1 ms for colours in RGB, 2 ms for Lab and Diverging; 89 KiB.
class LookTable {
 public:
  static constexpr int kCells = 4096;
  static constexpr int kEntries = kCells + 1;
  static constexpr int kPaddedEntries = kCells + 16;
  static constexpr int kMinFeatureCells = 4;

  struct Sample {
    float r, g, b;  // not premultiplied
    float opacity;  // per unit distance
  };

  // `tf` is sorted and valid (Look::validate()).
  explicit LookTable(const TransferFunction& tf);

  const LookAxis& axis() const noexcept { return axis_; }
  const float* red() const noexcept { return tables_->r; }
  const float* green() const noexcept { return tables_->g; }
  const float* blue() const noexcept { return tables_->b; }
  const float* opacity() const noexcept { return tables_->opacity; }

  // Whether any cell has a step; then which: the fraction of the cell where it lies, -1 in others.
  bool has_steps() const noexcept { return has_steps_; }
  const float* step() const noexcept { return tables_->step; }

  Sample at(float value) const noexcept {
    const float t = coordinate(value);
    return {read(tables_->r, t), read(tables_->g, t), read(tables_->b, t),
            read(tables_->opacity, t)};
  }

  // What the reading rule makes of `entries`, kPaddedEntries of them.
  float read(const std::vector<float>& entries, float value) const noexcept {
    return read(entries.data(), coordinate(value));
  }

  // Whether a value in [lo, hi] can have an opacity other than zero, in this table or by exact
  // evaluation: never false where one of the two is not zero; false if lo > hi. Infinite ends are
  // allowed. Cost: a few loads, and where the table is zero a search among the separate stretches
  // of the curve (most have one).
  bool any_opacity(float lo, float hi) const noexcept;

  // The greatest opacity of any value, in this table or by exact evaluation.
  float max_opacity() const noexcept { return max_opacity_; }

 private:
  struct alignas(64) Tables {
    float r[kPaddedEntries], g[kPaddedEntries], b[kPaddedEntries], opacity[kPaddedEntries];
    float step[kPaddedEntries];
    // How many of entries 0 to i - 1 are not zero.
    std::int16_t opaque_entries_before[kEntries + 1];
  };

  float read(const float* x, float t) const noexcept {
    const int i = static_cast<int>(t);
    float f = t - static_cast<float>(i);
    if (tables_->step[i] >= 0.0F) f = f >= tables_->step[i] ? 1.0F : 0.0F;
    return x[i] + f * (x[i + 1] - x[i]);
  }
  float coordinate(float value) const noexcept {
    return std::min(std::max(axis_.place(value), 0.0F), static_cast<float>(kCells));
  }

  void place(const TransferFunction& tf);
  double entry_value(int i) const noexcept { return axis_.value_of_entry(i); }
  void fill(const TransferFunction& tf);
  void keep_step_at(double value);
  void keep_steps(const TransferFunction& tf);
  void keep_zero_at(float value);
  void keep_zeros(const TransferFunction& tf);
  void find_showing(const TransferFunction& tf);
  void count_opaque_entries();

  struct Interval {
    float first, last;  // both included
  };
  LookAxis axis_;
  float max_opacity_ = 0.0F;
  bool has_steps_ = false;
  std::unique_ptr<Tables> tables_;
  std::vector<Interval> showing_;  // where the exact curve is not zero: rising, apart
};

}  // namespace ovoid::view
