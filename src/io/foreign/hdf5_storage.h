// SPDX-License-Identifier: Apache-2.0
// Where the numbers of an HDF5 dataset lie in the file. They are read and unpacked here and not by
// the library, which trusts the sizes of damaged chunks and reads past their ends; of the library
// it takes what describes them.
#pragma once

#include <hdf5.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/core/byte_source.h"
#include "io/core/samples.h"
#include "ovoid/lattice.h"

namespace ovoid::io {

// A type of numbers as files have it.
struct Hdf5Type {
  ScalarType type;
  bool is_big_endian;
};

// Nothing for a type other than integers of 1 to 8 bytes and IEEE floats of 4 and 8.
std::optional<Hdf5Type> hdf5_type_of(hid_t type);

// What is to be read. The caller has checked that the sizes are at least 1 and that num_bytes() is
// at most kMaxNumBytes.
struct Hdf5Extent {
  static constexpr std::size_t kMaxRank = 4;

  std::string where;  // file and dataset, for messages
  Hdf5Type type;
  std::vector<std::int64_t> dims;  // 1 to kMaxRank axes, slowest first

  std::int64_t item_size() const noexcept { return static_cast<std::int64_t>(size_of(type.type)); }
  std::int64_t num_bytes() const noexcept {
    std::int64_t count = item_size();
    for (const std::int64_t dim : dims) count *= dim;
    return count;
  }
};

// Throws Error unless the numbers can be in the file, by their sizes: kFileFormat; kUnsupported for
// what lies in other files, was never written, or is compressed by another filter than deflate,
// shuffle and Fletcher's checksum, which is not verified. Takes no memory.
void check_hdf5_storage(hid_t dataset, const Hdf5Extent& extent, const ByteSource& source);

// The numbers, last axis fastest, native byte order, into extent.num_bytes() bytes at `to`, after
// check_hdf5_storage(). Throws Error(kFileFormat) for chunks that are broken, Error(kCancelled).
void read_hdf5_storage(hid_t dataset, const Hdf5Extent& extent, const ByteSource& source,
                       std::byte* to, ReadProgress& progress);

}  // namespace ovoid::io
