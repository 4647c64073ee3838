// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/dataset.h"

namespace ovoid::data {

// True if two finite values of one component differ. Ends at the first difference, so real data
// costs next to nothing.
bool varies(const DataArray& array);

}  // namespace ovoid::data
