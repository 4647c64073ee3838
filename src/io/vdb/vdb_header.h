// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/core/byte_source.h"

namespace ovoid::io {

// A grid as its descriptor has it.
struct VdbEntry {
  std::string name;  // as OpenVDB calls it: "density", of several of one name "density[1]"
  std::string type;  // of its tree: "Tree_float_5_4_3"
};

struct VdbHeader {
  std::uint32_t version = 0;  // of the file format
  // Says the file where its grids are? Else it was written as a stream, and grids are not listed.
  bool has_offsets = false;
  std::vector<VdbEntry> grids;  // in the order of the file
};

// Walks the header, the descriptors of all grids and their metadata, and holds all sizes and places
// in them to the file's size before OpenVDB believes them. Little endian, as OpenVDB writes it
// everywhere. Throws Error(kFileFormat), or kUnsupported for a version older than 222 (2013).
VdbHeader read_vdb_header(const ByteSource& source);

}  // namespace ovoid::io
