// SPDX-License-Identifier: Apache-2.0
// Readers of meshes that are not VTK's own text formats; all stand on VTK's.
#pragma once

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Throws Error(kFileFormat) unless the hierarchy, or the one beside the file, names HDF5 files that
// are there and have the size that they state.
void check_enzo(const ByteSource& named);

// Read the step and the blocks that `options` say (mesh_of_parts, read_mesh_step), Enzo as boxes.
// VTK's readers believe what foreign_readers.cpp has not checked before; what comes out is checked.
// Throw Error.
Dataset read_exodus(const ByteSource& source, const ReadOptions& options);
Dataset read_enzo(const ByteSource& source, const ReadOptions& options);
Dataset read_ensight(const ByteSource& source, const ReadOptions& options);

}  // namespace ovoid::io
