// SPDX-License-Identifier: Apache-2.0
// Samples that a text header leaves to files beside it: their names, and what each of them holds.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/core/byte_source.h"
#include "ovoid/lattice.h"

namespace ovoid::io {

// Where detached samples lie: one name, a list, or numbered names, which are not spelled out
// because a header may claim any number of them.
struct DataFiles {
  std::vector<std::string> names;  // one name or a list; empty if numbered
  std::string before, after;  // numbered: name = before + number, padded to `width` digits, + after
  char padding = ' ';
  int width = 0;
  std::int64_t first = 0, step = 1;
  std::int64_t count = 0;
  // Axes in one file; default: all but the slowest if there are several files.
  std::optional<int> subdimension;

  std::string name(std::int64_t index) const;
};

// Takes "name%03d.raw" apart at its one conversion; false if it has none, or another one. The text
// is never given to printf.
bool parse_numbered_name(std::string_view pattern, DataFiles& files);

// Numbers from `first` to `last`; false if `step` leads away from it.
bool number_files(DataFiles& files, std::int32_t first, std::int32_t last, std::int32_t step);

// How the samples are spread over files: every part holds the same number of bytes.
struct DataParts {
  std::int64_t count = 1;
  std::int64_t num_bytes_each = 0;
  std::string layout_each;
};

// `where` names file and field for messages. `sizes`: of all axes, fastest first; `num_bytes`: of
// all samples. Throws Error(kFileFormat) if the files cannot share them evenly.
DataParts divide_samples(const std::string& where, const DataFiles& files,
                         std::vector<std::int64_t> sizes, ScalarType type, std::int64_t num_bytes);

// The file that `header` calls `name`. Throws as `open` does, with `where` in front; Error
// (kFileFormat) if it is the header itself.
std::unique_ptr<ByteSource> open_data_file(const ByteSource& header, const std::string& where,
                                           const std::string& name, const Opener& open);

}  // namespace ovoid::io
