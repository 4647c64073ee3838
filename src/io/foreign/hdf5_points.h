// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/core/byte_source.h"
#include "io/core/row_share.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Is something in the HDF5 file called like positions, and may be some? False in a build without
// HDF5.
bool has_hdf5_positions(const ByteSource& source);

// Reads particles from the HDF5 file called source.name(): options.hdf5.positions, or what is
// called like positions; options.hdf5.values, or what lies beside them and has as many rows
// (docs/formats.md, "HDF5"); options.share of the rows. Positions are float32 or float64, arrays
// have the file's types. Peak memory is that of the arrays' rows and a chunk. Calls into the
// library are made one at a time. Throws Error; kUnsupported in a build without HDF5.
Dataset read_hdf5_points(const ByteSource& source, const ReadOptions& options);

// Where a file has something called like positions, and how many.
struct Hdf5PointsPlace {
  std::string path, group;
  std::int64_t count = 0;
};
std::vector<Hdf5PointsPlace> hdf5_points_in(const std::string& path);

// The rows of the file's particles at options.hdf5.positions, which must be there; options.share is
// not looked at.
Dataset read_hdf5_rows_of_points(const std::string& path, const ReadOptions& options,
                                 const Rows& rows);

}  // namespace ovoid::io
