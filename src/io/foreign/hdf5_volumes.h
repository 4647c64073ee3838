// SPDX-License-Identifier: Apache-2.0
// Arrays on a lattice in HDF5 files, whatever dialect says where they are.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/foreign/hdf5_file.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

struct Hdf5Volume {
  const Hdf5Dataset* dataset = nullptr;  // of numbers, 2 to 5 axes
  std::string name;                      // of the array
  std::string axes;                      // a letter for each axis (axis_order.h)
  std::vector<std::int64_t> sizes{};  // that are read along each axis, from its front; empty: all
};

// Reads them, which agree in the sizes of x, y, z and time, into `dataset`: lattice.dims, arrays,
// and of those in time num_steps and step (options.step, or the first that varies). options.array
// is not looked at. Scale, unit and missing samples are as CF's attributes say (cf_conventions.h).
// Several of them: those whose storage is not read are left out, with a note. Throws what
// check_hdf5_storage() and read_chunked() do, where none is left.
void read_hdf5_volumes(const Hdf5File& file, const std::vector<Hdf5Volume>& volumes,
                       const ReadOptions& options, Dataset& dataset);

// A path for a message: the end of a long one.
std::string hdf5_path_text(const std::string& path);

// "'/a' [4, 5, 6], '/b' [3, 3]" and how many more there are.
std::string hdf5_list(const std::vector<const Hdf5Dataset*>& datasets);

// The one that is asked for by its path, or its end that one alone has ("E/x", "x"); throws
// Error(kInvalidArgument) if several have it. None: null.
const Hdf5Dataset* hdf5_named(const Hdf5File& file, const std::string& asked,
                              const std::vector<const Hdf5Dataset*>& among);

}  // namespace ovoid::io
