// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "io/foreign/hdf5_file.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Which HDF5 files are looked at.
enum class Hdf5Axes {
  kScales,        // those with dimension scales, as netCDF-4 writes them
  kScalesOrNames  // others, too, where arrays of one axis are called like axes and as long as they
};

// Reads variables on a grid, as docs/formats.md, "netCDF", says. HDF5's own library tells the
// dimension scales [HDF5]. `file` lists datasets of Hdf5Extent::kMaxRank axes. Nothing where there
// are none, or none of those that are looked at. Throws what read_cf_grid() does.
std::optional<Dataset> read_hdf5_cf(const Hdf5File& file, const ReadOptions& options,
                                    Hdf5Axes axes);

}  // namespace ovoid::io
