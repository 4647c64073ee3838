// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "io/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Reads an NRRD volume; `open` finds detached data, whose names are relative to the header's
// folder. Two or three spatial axes, after at most one axis of components. The array is called by
// the header's content, or "values". Throws Error.
Dataset read_nrrd(const ByteSource& source, const ReadOptions& options,
                  const Opener& open = open_file);

// Writes the dataset's only array: attached and raw (.nrrd), or as a text header beside a .raw file
// of the same stem (.nhdr). Geometry, patient space, array name and unit are kept. Throws
// Error(kFileWrite).
void write_nrrd(const Dataset& dataset, const DataArray& array, const std::string& path);
void write_nhdr(const Dataset& dataset, const DataArray& array, const std::string& path);

}  // namespace ovoid::io
