// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "ovoid/field.h"

namespace ovoid::model {

// The stored numbers of a box of samples, lo <= (i, j, k) < hi, k the layer, as doubles, x fastest;
// NaN where missing. Kept from box to box, so that memory is asked for once.
struct SampleWindow {
  Index3 lo{}, hi{};
  std::vector<double> numbers;
  bool has_missing = false;

  // Throws what the source throws. Cost: each brick that the box meets is acquired once.
  void load(const BrickSource& source, const Index3& first, const Index3& end);

  const double* row(std::int64_t j, std::int64_t k) const noexcept {
    return numbers.data() + start_of_row(j, k);
  }
  std::int64_t start_of_row(std::int64_t j, std::int64_t k) const noexcept {
    return (hi[0] - lo[0]) * ((j - lo[1]) + (hi[1] - lo[1]) * (k - lo[2]));
  }
};

}  // namespace ovoid::model
