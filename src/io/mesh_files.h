// SPDX-License-Identifier: Apache-2.0
// Files of meshes that are not VTK's own text formats: which they are, and their readers, which all
// stand on VTK's. Without VTK (OVOID_IO_VTK off) the readers throw Error(kUnsupported) that names
// the format.
#pragma once

#include <string>
#include <string_view>

#include "io/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

enum class MeshFile { kNone, kExodus, kVtkHdf, kEnzo, kEnSight };

// "Exodus", "VTKHDF", ...; "" for kNone.
const char* name_of(MeshFile kind) noexcept;

// From the file's first 512 bytes and, where those cannot tell, from its name: netCDF files and
// HDF5 files called .e .ex2 .exo .exii .g are Exodus, HDF5 files with a group VTKHDF are VTKHDF;
// NAME.hierarchy, or NAME beside it, is Enzo; .case is EnSight.
MeshFile mesh_file_of(const ByteSource& source, std::string_view start);

// Reads what mesh_file_of has told: the step and the blocks that `options` say (mesh_of_parts,
// read_mesh_step), Enzo as boxes. Checks before VTK sees the file: netCDF headers are there whole
// with all variables (check_netcdf), HDF5 files have the size that they state, Enzo's hierarchy
// names files that are there. VTK's readers believe the rest; what comes out is checked. Throws
// Error.
Dataset read_mesh_file(MeshFile kind, const ByteSource& source, const ReadOptions& options);

// One each, behind the checks.
Dataset read_exodus(const ByteSource& source, const ReadOptions& options);
Dataset read_vtk_hdf(const ByteSource& source, const ReadOptions& options);
Dataset read_enzo(const ByteSource& source, const ReadOptions& options);
Dataset read_ensight(const ByteSource& source, const ReadOptions& options);

}  // namespace ovoid::io
