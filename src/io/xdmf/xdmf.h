// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

bool is_xdmf(const ByteSource& source, std::string_view start);

// Reads a lattice, mesh or particles: of a temporal collection options.step, of several grids
// options.block. What lies in HDF5 is read in the reader's process (set_xdmf_hdf5()). `open` opens
// files of raw numbers. Throws Error.
Dataset read_xdmf(const ByteSource& source, const ReadOptions& options, const Opener& open);

// All files that its items lie in, as far as they are there.
std::vector<std::string> xdmf_companions(const ByteSource& source);

// Of the first grid that has one.
std::optional<double> time_of_xdmf(const ByteSource& source);

}  // namespace ovoid::io
