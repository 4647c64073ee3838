// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/core/byte_source.h"

namespace ovoid::io {

// The header of a classic netCDF file (CDF-1, CDF-2, CDF-5; "NetCDF Classic Format Specification"):
// dimensions, attributes and variables must be well-formed, and the file as long as its variables
// say with all records; and it must have the attribute `api_version`, which Exodus files have and
// other netCDF files have not. Nothing is allocated in proportion to a claim. Throws
// Error(kFileFormat) naming the variable, what it needs and what there is, or kUnsupported.
void check_exodus(const ByteSource& source);

// An HDF5 file whose superblock says that it is longer than it is was cut off. Throws
// Error(kFileFormat).
void check_hdf5_size(const ByteSource& source);

}  // namespace ovoid::io
