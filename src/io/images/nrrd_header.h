// SPDX-License-Identifier: Apache-2.0
// The text part of an NRRD file (NRRD0001 to NRRD0005, attached or detached), taken apart and
// checked field by field, but not yet understood as a volume. Format:
// teem.sourceforge.net/nrrd/format.html.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/core/byte_source.h"
#include "io/core/decode.h"
#include "io/images/data_files.h"
#include "ovoid/lattice.h"

namespace ovoid::io {

// One axis as the per-axis fields describe it; absent fields are empty.
struct NrrdAxis {
  std::int64_t size = 0;
  std::string kind;  // lower case; empty: unknown
  std::optional<double> spacing;
  std::optional<double> min, max;
  bool is_node_centered = false;
  std::string unit;                                // of the places along it
  std::optional<std::array<double, 3>> direction;  // empty: "none", or no space directions
  std::optional<double> fourth;                    // of a direction in a space of four dimensions
};

struct NrrdHeader {
  ScalarType type = ScalarType::kUInt8;
  Encoding encoding = Encoding::kRaw;
  std::optional<bool> is_big_endian;
  std::vector<NrrdAxis> axes;   // fastest first
  bool has_directions = false;  // "space directions" is there
  bool has_centers = false;
  // As the format spells it in full ("left-posterior-superior"); empty if unnamed.
  std::string space;
  int space_dimension = 0;  // 0: no space; at most 4 where directions or an origin follow
  std::optional<std::array<double, 3>> origin;
  std::optional<double> origin_fourth;
  std::vector<std::string> space_units;
  bool has_turned_frame = false;  // a measurement frame that is not the identity
  std::string content, unit;
  std::int64_t line_skip = 0;
  std::int64_t byte_skip = 0;      // -1: the last bytes of the file
  std::optional<DataFiles> files;  // empty: attached
  std::int64_t data_offset = 0;    // attached: first byte after the blank line
  // Keys and values of 3D Slicer's: what says of which step a frame of a sequence is, and whether
  // layers are those of a segmentation.
  std::map<std::string, std::string> sequence_keys;
  bool is_segmentation = false;
  std::vector<std::string> notes;  // fields that were not understood
};

bool looks_like_nrrd(std::string_view start) noexcept;

// Reads and checks the header of `source`. Throws Error(kFileFormat, kUnsupported) naming file,
// line and field.
NrrdHeader read_nrrd_header(const ByteSource& source);

}  // namespace ovoid::io
