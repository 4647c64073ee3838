// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// A VTKHDF file [VTKHDF]: the step that `options` say (read_mesh_step); images as lattices,
// adaptive grids as boxes, the rest as mesh_of_parts() says. What is in its blocks is put together
// as dataset_of_lattices() and mesh_of_parts() do. Throws Error: kFileFormat for what is wrong,
// kUnsupported for data sets of another kind.
Dataset read_vtk_hdf(const ByteSource& source, const ReadOptions& options);

}  // namespace ovoid::io
