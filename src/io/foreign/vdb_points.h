// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/foreign/vdb_file.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// The points of such a grid as particles: places in the world, and attributes of numbers as arrays.
// Others are left out with a note. Throws Error: kFileFormat for a grid without points or one whose
// voxels claim points that are not there; kOutOfMemory, kCancelled.
void read_vdb_points(VdbFile& file, const VdbGrid& grid, const ReadOptions& options,
                     Dataset& dataset);

}  // namespace ovoid::io
