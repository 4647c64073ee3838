// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "io/foreign/hdf5_file.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Reads the arrays of three axes (z, y, x), or four with components, from an HDF5 file that is of
// none of the dialects that are known: options.array by its path or the end of it, or all, if they
// are of one size. Attributes of the array say axes, spacing, origin, unit and scale
// (docs/formats.md, "HDF5: grids"). `file` lists datasets of Hdf5Extent::kMaxRank axes. Nothing if
// there are no such arrays, or if options.array names another one. Throws Error; kInvalidArgument
// that lists the arrays if several sizes are there and none is chosen.
std::optional<Dataset> read_hdf5_grid(const Hdf5File& file, const ReadOptions& options);

}  // namespace ovoid::io
