// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Reads a VTK file, XML or legacy, of one data set or one that names others (vtk_set_files.h). Each
// file is checked as it would be alone. Pieces and blocks become one mesh (mesh_of_parts), adaptive
// grids boxes, and of a time series one step is read. Throws Error; kUnsupported without VTK.
Dataset read_vtk(const ByteSource& source, const ReadOptions& options);

}  // namespace ovoid::io
