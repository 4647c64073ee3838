// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "ovoid/field.h"

namespace ovoid::cli {

// How often the drawn values occur.
struct Histogram {
  // Equal bins between two values, or between their logarithms to base 10.
  struct Bins {
    double lo = 0, hi = 1;
    std::vector<std::uint64_t> counts;  // empty: nothing known
    std::uint64_t greatest = 0;         // of the counts
  };
  Bins linear;
  Bins logarithmic;           // of values > 0: six decades, if there are as many
  std::vector<float> values;  // rising: some of those that were counted, evenly taken

  double quantile(double q) const;  // q in [0, 1]; NaN if there are no values
};

// Of a lattice's samples, and of the field at a kernel set's centres (a sum) or of its kernels'
// values (normalized). Bins span the field's value range; of whole numbers each has one of its own,
// if they are not too many. Of more than some millions of samples
// every n-th brick is taken. Throws what the field's source throws, and Error(kCancelled).
Histogram histogram_of(const Field& field, const std::stop_token& stop = {});

inline constexpr int kHistogramBins = 512;

}  // namespace ovoid::cli
