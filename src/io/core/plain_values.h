// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/dataset.h"

namespace ovoid::io {

// The array with its scale applied, for formats that cannot store one; the array itself if it has
// none. Values that are integers get the smallest integer type, not smaller than the stored one,
// that holds all of them; others float32, or float64 for stored integers of 4 and 8 bytes and for
// float64. Throws Error(kOutOfMemory).
DataArray plain_values(const DataArray& array);

}  // namespace ovoid::io
