// SPDX-License-Identifier: Apache-2.0
// The numbers of an HDF5 dataset. What it claims is compared with the file before memory is taken;
// then the library reads, which may still crash on damaged chunks: in a process of its own.
#pragma once

#include <hdf5.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/core/byte_source.h"
#include "io/core/samples.h"
#include "io/core/samples_in_file.h"
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
  static constexpr std::size_t kMaxRank = 5;

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
// shuffle and Fletcher's checksum. Takes no memory.
void check_hdf5_storage(hid_t dataset, const Hdf5Extent& extent, const ByteSource& source);

// Where in the file the numbers lie, as they are or in chunks that are deflated, shuffled or
// neither, after check_hdf5_storage(); nothing for those that lie otherwise.
std::optional<StoredPlace> place_of_hdf5_storage(hid_t file, hid_t dataset,
                                                 const Hdf5Extent& extent);

// The numbers, last axis fastest, native byte order, into extent.num_bytes() bytes at `to`, after
// check_hdf5_storage(). Throws Error(kFileFormat) for what is damaged, Error(kCancelled).
void read_hdf5_storage(hid_t dataset, const Hdf5Extent& extent, std::byte* to,
                       ReadProgress& progress);

// How many numbers along an axis are read at once: some megabytes, and whole chunks, so that each
// is unpacked once.
std::int64_t hdf5_run_at_once(hid_t dataset, const Hdf5Extent& extent, std::size_t axis);

// The same of the columns of a table of two axes, in one go: of each row those from `first` on, as
// many as fill `out`.
void read_hdf5_columns(hid_t dataset, const Hdf5Extent& extent, std::int64_t first,
                       std::span<std::byte> out, ReadProgress& progress);

// The same of the rows, along the slowest axis, from `first` on: as many as `out` takes.
void read_hdf5_rows(hid_t dataset, const Hdf5Extent& extent, std::int64_t first,
                    std::span<std::byte> out, ReadProgress& progress);

}  // namespace ovoid::io
