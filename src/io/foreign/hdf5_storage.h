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
#include "io/foreign/hdf5_types.h"
#include "ovoid/lattice.h"

namespace ovoid::io {

// What is to be read. The caller has checked that the sizes are at least 1 and that num_bytes() is
// at most kMaxNumBytes.
struct Hdf5Extent {
  static constexpr std::size_t kMaxRank = 8;

  std::string where;  // file and dataset, for messages
  Hdf5Type type;
  std::vector<std::int64_t> dims;  // 1 to kMaxRank axes, slowest first
  // Chunks that were never written hold the fill value, as other programs read them; not so in
  // Ovoid's own files, where something is missing then.
  bool may_have_gaps = false;

  std::int64_t item_size() const noexcept { return static_cast<std::int64_t>(size_of(type.type)); }
  std::int64_t num_numbers() const noexcept {
    std::int64_t count = 1;
    for (const std::int64_t dim : dims) count *= dim;
    return count;
  }
  std::int64_t num_bytes() const noexcept { return num_numbers() * item_size(); }  // in memory
  std::int64_t num_stored_bytes() const noexcept { return num_numbers() * type.stored_size(); }
};

// Throws Error unless the numbers can be in the file, by their sizes: kFileFormat; kUnsupported for
// what lies in other files, was never written, or is compressed by a filter that is not read
// (hdf5_filters.h). Takes no memory.
void check_hdf5_storage(hid_t dataset, const Hdf5Extent& extent, const ByteSource& source);

// Where in the file the numbers lie, as they are or in chunks that are deflated, shuffled or
// neither, after check_hdf5_storage(); nothing for those that lie otherwise.
std::optional<StoredPlace> place_of_hdf5_storage(hid_t file, hid_t dataset,
                                                 const Hdf5Extent& extent);

// How many chunks were never written; 0 of what is in one piece.
std::int64_t num_hdf5_gaps(hid_t dataset, const Hdf5Extent& extent);

// The numbers, last axis fastest, native byte order, into extent.num_bytes() bytes at `to`, after
// check_hdf5_storage(). Throws Error(kFileFormat) for what is damaged, Error(kCancelled).
void read_hdf5_storage(hid_t dataset, const Hdf5Extent& extent, std::byte* to,
                       ReadProgress& progress);

// The numbers of a box of it: `count` along each axis from `first` on, which are within the extent.
void read_hdf5_box(hid_t dataset, const Hdf5Extent& extent, std::span<const std::int64_t> first,
                   std::span<const std::int64_t> count, std::span<std::byte> out,
                   ReadProgress& progress);

// Numbers of a chunk along each axis; 1 along all where there are no chunks.
std::vector<std::int64_t> hdf5_chunk_sizes(hid_t dataset, const Hdf5Extent& extent);

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
