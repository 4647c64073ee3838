// SPDX-License-Identifier: Apache-2.0
// Readers of meshes that are not VTK's own text formats; all stand on VTK's.
#pragma once

#include "io/core/byte_source.h"
#include "io/meshes/mesh_files.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Reads what mesh_file_of has told: the step and the blocks that `options` say (mesh_of_parts,
// read_mesh_step), Enzo as boxes. Checks before VTK sees the file: netCDF headers are there whole
// with all variables (check_exodus), HDF5 files have the size that they state, Enzo's hierarchy
// names files that are there. VTK's readers believe the rest; what comes out is checked. Throws
// Error; kUnsupported without VTK.
Dataset read_mesh_file(MeshFile kind, const ByteSource& source, const ReadOptions& options);

// One each, behind the checks.
Dataset read_exodus(const ByteSource& source, const ReadOptions& options);
Dataset read_vtk_hdf(const ByteSource& source, const ReadOptions& options);
Dataset read_enzo(const ByteSource& source, const ReadOptions& options);
Dataset read_ensight(const ByteSource& source, const ReadOptions& options);

}  // namespace ovoid::io
