// SPDX-License-Identifier: Apache-2.0
// What readers of points do with arrays that they have.
#pragma once

#include <cstdint>

#include "ovoid/dataset.h"

namespace ovoid::io {

// Integers as float64, floats as they are: positions are floats. Throws Error(kOutOfMemory).
DataArray floating_values(const DataArray& array);

// `count` components of each tuple from `first` on, as an array of their own. Throws
// Error(kOutOfMemory).
DataArray take_components(const DataArray& array, int first, int count);

// Memory for an array of `num_tuples` tuples, to be filled: `to` points at it. The size is at most
// kMaxNumBytes. Throws Error(kOutOfMemory).
DataArray new_array(DataArray description, std::byte*& to);

}  // namespace ovoid::io
