// SPDX-License-Identifier: Apache-2.0
// ParaView's file series (NAME.vtu.series, NAME.vtm.series, ...): JSON that names files, of any
// format, which are the time steps of one dataset [ParaView].
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// What the row of the table of formats is called.
inline constexpr const char* kFileSeries = "VTK file series";

// `start`: the first 512 bytes.
bool is_file_series(const ByteSource& source, std::string_view start);

struct FileSeries {
  std::vector<std::string> paths;  // at least one; names count from the series' folder
  std::vector<double> times;       // rising, one each; empty unless every file has its own
};

// In the order of the times, else as they stand. Throws Error(kFileFormat) naming the place in the
// JSON, kUnsupported for more than kMaxVtkSetFiles.
FileSeries file_series(const ByteSource& source);

std::vector<std::string> file_series_companions(const ByteSource& source);

// Reads a step by the format of its own file. Every file is looked for before one is read, through
// `open`. Throws Error: kFileNotFound naming series and file, kUnsupported for a file that is a
// series, and what reading a file throws.
Dataset read_file_series(const ByteSource& source, const ReadOptions& options, const Opener& open);

}  // namespace ovoid::io
