// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>

#include "ovoid/dataset.h"

namespace ovoid::cli {

// What the numbers of one array are, all components together.
struct ArrayFacts {
  double lo = std::numeric_limits<double>::infinity();
  double hi = -std::numeric_limits<double>::infinity();
  std::int64_t num_missing = 0;
};

// Looks at every number, in memory or in its file. Values are scaled.
ArrayFacts facts_of(const DataArray& array);

}  // namespace ovoid::cli
