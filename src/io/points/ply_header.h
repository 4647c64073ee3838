// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/core/byte_source.h"
#include "ovoid/kernels.h"
#include "ovoid/lattice.h"

namespace ovoid::io {

// A file begins with the line "ply".
bool looks_like_ply(std::string_view start) noexcept;

struct PlyProperty {
  std::string name;
  ScalarType type = ScalarType::kFloat32;  // of a list: of its entries
  bool is_list = false;
  ScalarType count_type = ScalarType::kUInt8;
};

// `count` records of the same properties.
struct PlyElement {
  std::string name;
  std::int64_t count = 0;
  std::vector<PlyProperty> properties;

  bool has_lists() const noexcept;
  std::int64_t row_size() const noexcept;  // bytes of a binary record without lists
};

struct PlyHeader {
  enum class Format { kAscii, kLittleEndian, kBigEndian } format = Format::kAscii;
  std::vector<PlyElement> elements;
  // Of stored kernels, from comments "ovoid reconstruction NAME" and "ovoid cutoff SIGMAS".
  std::optional<Reconstruction> reconstruction;
  std::optional<double> cutoff;
  std::int64_t data_offset = 0;
  std::int64_t num_lines = 0;  // of the header
};

// Throws Error(kFileFormat, kUnsupported) that names the line. Counts are not compared with the
// file yet; they are at most kMaxNumBytes / 2^20.
PlyHeader read_ply_header(const ByteSource& source);

}  // namespace ovoid::io
