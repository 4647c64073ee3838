// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/dataset.h"

namespace ovoid::io {

// The lattice of the array's own samples: cells lie half a spacing from the points, one fewer along
// every axis that has any.
LatticeGeometry lattice_of(const LatticeGeometry& points, const DataArray& array);

}  // namespace ovoid::io
