// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stop_token>
#include <string>

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Reads an NRRD volume; `open` finds detached data, whose names are relative to the header's
// folder. Two or three spatial axes, at most one of components and one of time or a list of
// volumes, in any order; components and steps that lie elsewhere than first and last cost a walk
// over all files. The array is called by the header's content, or "values". Throws Error.
Dataset read_nrrd(const ByteSource& source, const ReadOptions& options,
                  const Opener& open = open_file);

// Writes the dataset's only array: attached and raw (.nrrd), or as a text header (.nhdr) beside the
// samples. Geometry, patient space, array name and unit are kept. Throws Error(kFileWrite).
void write_nrrd(const Dataset& dataset, const DataArray& array, const std::string& path,
                const std::stop_token& stop = {});
void write_nhdr(const Dataset& dataset, const DataArray& array, const std::string& path,
                const std::stop_token& stop = {});

// Where write_nhdr puts the samples: a .raw file of the same stem.
std::string nhdr_data_path(const std::string& path);

// Throws Error(kFileWrite) if that is a file that the header at `path` does not name: it would be
// lost.
void check_nhdr_data_path(const std::string& path);

}  // namespace ovoid::io
