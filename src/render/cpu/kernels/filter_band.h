// SPDX-License-Identifier: Apache-2.0
// A filter of post-convolution along one axis, as a matrix of which only a band is not zero.
#pragma once

#include <array>

#include "render/shared/filters.h"

namespace ovoid::cpu {

// Output x is the sum over k of weight[k][x] times input `first_input` + k. Outputs beyond those
// that were set have no weights.
template <int kMaxOutputs, int kMaxInputs>
struct FilterBand {
  static constexpr int kOutputs = kMaxOutputs;  // a multiple of the largest SIMD group
  static constexpr int kInputs = kMaxInputs;

  // Rows of `weight` in which any of eight neighbouring outputs has weight.
  struct Range {
    int first = 0, past = 0;
  };

  int first_input = 0;
  std::array<int, kMaxOutputs> taps{};  // of each output: its first input
  std::array<Range, kMaxOutputs / 8> of_eight{};
  alignas(64) float weight[kMaxInputs][kMaxOutputs] = {};

  // Output x lies `phase`, in [0, 1), behind input `before`. To be called in the order of x.
  void set_output(int x, PostConvolution how, int before, double phase) {
    const FilterTaps weights = filter_taps(how, phase);
    const int tap = before - kTapsBefore;
    taps[static_cast<std::size_t>(x)] = tap;
    for (int k = 0; k < kFilterTaps; ++k)
      weight[tap - first_input + k][x] = static_cast<float>(weights[static_cast<std::size_t>(k)]);
    Range& range = of_eight[static_cast<std::size_t>(x / 8)];
    if (x % 8 == 0) range.first = tap - first_input;
    range.past = tap - first_input + kFilterTaps;
  }
};

}  // namespace ovoid::cpu
