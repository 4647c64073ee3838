// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Does the HDF5 file called source.name() say that it is one of these? False in a build without
// HDF5, and for a file that cannot be opened.
bool is_hdf5_lattice(const ByteSource& source);

// Reads one step of it: options.step, else the first in which an array varies; options.array alone
// if it is named. Nothing of other steps is read but for that search. Peak memory is the step and a
// chunk. Throws Error: kFileFormat naming the attribute or dataset, kUnsupported for a later
// version, kInvalidArgument for a step or an array that is not there, kCancelled.
Dataset read_hdf5_lattice(const ByteSource& source, const ReadOptions& options);

}  // namespace ovoid::io
