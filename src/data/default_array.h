// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "ovoid/dataset.h"

namespace ovoid::data {

// The array that is drawn where none is named (Dataset::array()). `varies`: whether an array of the
// dataset does. Null: there are no arrays.
const DataArray* default_array(const Dataset& dataset,
                               const std::function<bool(const DataArray&)>& varies);

}  // namespace ovoid::data
