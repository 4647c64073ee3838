// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Copies the cells of a share of a mesh, which stands whole in `dataset`, with their nodes and
// tuples, and releases the whole array by array. Of grids whole layers, which stay grids. Throws
// Error(kOutOfMemory).
void cut_cells_to_share(Dataset& dataset, const RowShare& share);

}  // namespace ovoid::io
