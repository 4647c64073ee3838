// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// XDMF whose numbers lie in HDF5 files, through the HDF5 library (set_xdmf_hdf5()). Throws Error.
Dataset read_xdmf_with_hdf5(const ByteSource& source, const ReadOptions& options);

}  // namespace ovoid::io
