// SPDX-License-Identifier: Apache-2.0
// Files of meshes that are not VTK's own text formats: which they are.
#pragma once

#include <string_view>

#include "io/core/byte_source.h"

namespace ovoid::io {

enum class MeshFile { kNone, kExodus, kVtkHdf, kEnzo, kEnSight };

// "Exodus", "VTKHDF", ...; "" for kNone.
const char* name_of(MeshFile kind) noexcept;

// From the file's first 512 bytes and, where those cannot tell, from its name: netCDF files and
// HDF5 files called .e .ex2 .exo .exii .g are Exodus, HDF5 files with a group VTKHDF are VTKHDF;
// NAME.hierarchy, or NAME beside it, is Enzo; .case is EnSight.
MeshFile mesh_file_of(const ByteSource& source, std::string_view start);

}  // namespace ovoid::io
