// SPDX-License-Identifier: Apache-2.0
// How files of meshes are recognised that are not told from their first bytes alone. `start`: the
// first 512 bytes.
#pragma once

#include <string_view>
#include <vector>

#include "io/core/byte_source.h"

namespace ovoid::io {

inline const std::vector<std::string_view> kExodusEndings{".e",    ".ex2",   ".exo",
                                                          ".exii", ".ex2v2", ".g"};

bool is_exodus(const ByteSource& source,
               std::string_view start);  // netCDF of Exodus', or HDF5 called so
bool is_vtk_hdf(const ByteSource& source, std::string_view start);  // HDF5 with a group VTKHDF
bool is_enzo(const ByteSource& source,
             std::string_view start);                           // NAME.hierarchy, or NAME beside it
bool is_stl(const ByteSource& source, std::string_view start);  // by name
bool is_obj(const ByteSource& source, std::string_view start);  // by name
bool is_ensight(const ByteSource& source, std::string_view start);  // by name

}  // namespace ovoid::io
