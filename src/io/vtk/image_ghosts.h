// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/dataset.h"

namespace ovoid::io {

// Honours the ghost arrays of a lattice, and takes them out: the values of hidden points and cells
// become missing, and so do those of cells with a hidden point and of points whose cells are all
// hidden. Integers become float32, or float64 where that is needed to hold them. Duplicates keep
// their values. Notes tell what was hidden. Throws Error(kFileFormat) if no other array is there,
// kOutOfMemory.
void hide_ghosts(Dataset& dataset);

}  // namespace ovoid::io
