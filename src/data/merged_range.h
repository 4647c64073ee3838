// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/field.h"

namespace ovoid::data {

// The range of all samples that exist: every one lies in the range of its own brick. Empty if none
// exists. Cost: one brick_range() per brick.
ValueRange merged_range(const BrickSource& source) noexcept;

}  // namespace ovoid::data
