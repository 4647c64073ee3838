// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/core/samples.h"
#include "io/foreign/vdb_file.h"
#include "ovoid/dataset.h"

namespace ovoid::io {

// The values of all voxels in the box, x fastest: those of active voxels and of others alike, tiles
// and the background where there are no voxels. `grid` was read and has `described.values`; `box`
// is in its indices and not empty. Throws Error(kOutOfMemory, kCancelled). `progress` counts the
// array's bytes.
DataArray dense_samples(const openvdb::GridBase& grid, const VdbGrid& described,
                        const VoxelBox& box, ReadProgress& progress);

}  // namespace ovoid::io
