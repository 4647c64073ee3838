// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "ovoid/field.h"

namespace ovoid::data {

// Makes the range hold the other, too.
inline void merge(ValueRange& range, const ValueRange& other) noexcept {
  if (other.is_empty()) return;
  range = range.is_empty() ? other
                           : ValueRange{std::min(range.lo, other.lo), std::max(range.hi, other.hi)};
}

// The range of all samples that exist: every one lies in the range of its own brick. Empty if none
// exists. Cost: one brick_range() per brick.
ValueRange merged_range(const BrickSource& source) noexcept;

}  // namespace ovoid::data
