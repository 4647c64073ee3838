// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// read_dataset for one file that is open, or in memory: tells the format, reads, and makes what the
// file wrote fit for a terminal: control characters in messages, notes, names and units become '?'.
// VTK formats are read from the file called source.name(). `steps`: the files of the series that it
// is one of, or none. Throws Error.
Dataset read_source(const ByteSource& source, const ReadOptions& options,
                    const Opener& open = open_file, const std::vector<std::string>& steps = {});

}  // namespace ovoid::io
