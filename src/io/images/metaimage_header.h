// SPDX-License-Identifier: Apache-2.0
// The text part of a MetaImage file (.mhd, .mha), taken apart and checked field by field, but not
// yet understood as a volume. Source: [MetaIO].
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/core/byte_source.h"
#include "io/images/data_files.h"
#include "ovoid/lattice.h"

namespace ovoid::io {

struct MetaImageHeader {
  std::vector<std::int64_t> sizes;  // two to four axes, fastest first
  ScalarType type = ScalarType::kUInt8;
  int num_channels = 1;
  std::optional<bool> is_big_endian;
  bool is_binary = true;
  bool is_compressed = false;
  std::int64_t compressed_size = 0;  // 0: not said
  std::int64_t header_size = 0;      // bytes before the samples of each file; -1: they end it
  std::vector<double> spacing;       // of each axis; 1 where not said
  std::vector<double> offset;        // of the first sample; 0 where not said
  std::vector<double> directions;    // [axis][world]: a unit vector for each axis
  double value_scale = 1, value_offset = 0;
  std::string name;
  std::optional<DataFiles> files;  // empty: behind the header
  std::int64_t data_offset = 0;    // behind the header
  std::vector<std::string> notes;  // fields that were not understood
};

bool looks_like_metaimage(std::string_view start) noexcept;

// Reads and checks the header of `source`. Throws Error(kFileFormat, kUnsupported) naming file,
// line and field.
MetaImageHeader read_metaimage_header(const ByteSource& source);

}  // namespace ovoid::io
