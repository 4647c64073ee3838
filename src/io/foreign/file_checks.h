// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/core/byte_source.h"

namespace ovoid::io {

// The header of a classic netCDF file, which must be one of Exodus' (io/netcdf/netcdf_header.h):
// VTK's reader believes it. Throws Error(kFileFormat), or kUnsupported.
void check_exodus(const ByteSource& source);

// An HDF5 file whose superblock says that it is longer than it is was cut off. Throws
// Error(kFileFormat).
void check_hdf5_size(const ByteSource& source);

}  // namespace ovoid::io
