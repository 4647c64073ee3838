// SPDX-License-Identifier: Apache-2.0
// What the header of a NumPy array says, in a file of its own or within an NPZ.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/core/byte_source.h"
#include "io/core/row_share.h"
#include "io/core/samples.h"
#include "ovoid/io.h"
#include "ovoid/lattice.h"

namespace ovoid::io {

inline constexpr std::string_view kNpyMagic = "\x93NUMPY";

struct NpyHeader {
  std::string descr;
  bool is_fortran_order = false;
  std::vector<std::int64_t> shape;
  std::int64_t data_offset = 0;
};

// Throws Error: kFileFormat, kUnsupported.
NpyHeader read_npy_header(const ByteSource& source);

struct NpyType {
  ScalarType type;
  bool is_big_endian;
  bool is_boolean;
};

// What NpyHeader::descr stands for. `name`: the file's. Throws Error(kUnsupported).
NpyType npy_type_of(const std::string& name, const std::string& descr);

// Throws Error(kFileFormat) unless the file ends with the last of the samples, `num_bytes` in all.
void check_npy_size(const ByteSource& source, const NpyHeader& header, ScalarType type,
                    std::int64_t num_bytes);

// The samples as the file orders them, native byte order.
struct NpySamples {
  NpyHeader header;
  ScalarType type = ScalarType::kFloat32;
  bool is_boolean = false;
  Rows rows;  // of the first axis: all, or the share's
  SampleBuffer samples;
};

// `share`: of the rows of an array of one or two axes; the others are not read. Throws Error; the
// file must end with the last sample.
NpySamples read_npy_samples(const ByteSource& source, const ReadOptions& options,
                            const std::optional<RowShare>& share = {});

}  // namespace ovoid::io
