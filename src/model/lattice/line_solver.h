// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "ovoid/field.h"
#include "ovoid/kernels.h"

namespace ovoid::model {

// Lines of samples side by side: sample j of lane i is at first + (j - first_sample) * stride + i.
struct Lines {
  float* first;
  std::int64_t stride;
  std::int64_t lanes;
  std::int64_t first_sample = 0;

  float* sample(std::int64_t j) const { return first + (j - first_sample) * stride; }
};

// Samples of lines -> coefficients of the field that takes their values at the samples, along one
// axis (prefilter.h): the matrix G_ji = g(j - i), symmetric and banded, is factored once as L D L^T
// in double, and lines are solved in floats, in place, where the compiler makes vectors of lanes.
// Positive definite where least_response() > 0: no pivots.
class LineSolver {
 public:
  LineSolver(std::int64_t size, const LatticeKernel& kernel, Reconstruction reconstruction);

  std::int64_t size() const { return size_; }
  std::int64_t band() const { return band_; }

  // As many samples behind a line's part are enough for the part's coefficients: what lies farther
  // changes them by less than 2e-7 of its own.
  std::int64_t look_ahead() const { return look_ahead_; }

  void solve(const Lines& lines) const {
    eliminate(lines, 0, size_);
    substitute(lines, 0, size_);
  }

  // The two halves of solve(), for parts of lines: samples [begin, end) are eliminated, where the
  // band() before them have been; then replaced by coefficients, as if lines ended at `end`.
  void eliminate(const Lines& lines, std::int64_t begin, std::int64_t end) const;
  void substitute(const Lines& lines, std::int64_t begin, std::int64_t end) const;

 private:
  // L(j, j - k), 1 <= k <= band.
  float lower(std::int64_t j, std::int64_t k) const { return lower_[j * band_ + k - 1]; }

  void factor();
  void scale_rows(const LatticeKernel& kernel, Reconstruction reconstruction);
  std::int64_t find_look_ahead() const;

  std::int64_t size_;
  std::int64_t band_ = 0;
  std::int64_t look_ahead_ = 0;
  std::vector<double> taps_;
  std::vector<float> lower_;          // [size][band]
  std::vector<float> inverse_pivot_;  // [size]
  std::vector<float> right_side_;     // [size]
};

// g(0), g(1), ... to the last that is not 0: on the cut-off of a Gaussian it counts half, as the
// field has it there, so that the field's limits on both sides of a sample have the sample's value
// for their mean.
std::vector<double> one_axis_taps(const LatticeKernel& kernel);

}  // namespace ovoid::model
