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
#include "io/core/short_floats.h"
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
  ScalarType type;  // of short floats that of their bits
  bool is_big_endian;
  bool is_boolean;
  ShortFloat short_float = ShortFloat::kNone;

  const char* name() const noexcept;
  // What the samples become, where that is another type, for Dataset::notes; of the file `source`.
  std::optional<std::string> note(const std::string& source) const;
};

// What NpyHeader::descr stands for. `name`: the file's. Throws Error(kUnsupported).
NpyType npy_type_of(const std::string& name, const std::string& descr);

// Throws Error(kFileFormat) unless the file ends with the last of the samples, `num_bytes` in all.
void check_npy_size(const ByteSource& source, const NpyHeader& header, const NpyType& type,
                    std::int64_t num_bytes);

// The samples as the file orders them, native byte order.
struct NpySamples {
  NpyHeader header;
  NpyType type{ScalarType::kFloat32, false, false};  // whose short floats are not widened yet
  Rows rows;                                         // of the first axis: all, or the share's
  SampleBuffer samples;
};

// `share`: of the rows of an array of one or two axes; the others are not read. Throws Error; the
// file must end with the last sample.
NpySamples read_npy_samples(const ByteSource& source, const ReadOptions& options,
                            const std::optional<RowShare>& share = {});

}  // namespace ovoid::io
