// SPDX-License-Identifier: Apache-2.0
// HDF5 files, made anew and filled: groups, packed datasets, attributes. The library is loaded when
// the first file is made: it and the thirty libraries that it brings would take longer to load than
// the rest of the program.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "ovoid/lattice.h"

namespace ovoid::io {

// Deflate at the level where, after shuffling, more effort buys next to nothing.
inline constexpr int kDeflateLevel = 4;

// A file, a group in it, or a dataset, as long as it stands open; to be closed before the object
// that it was made in. Every call that returns bool returns false if the library could not do it.
// Calls wait for one another, in whatever threads, as the library may have been built without a
// lock of its own; it prints nothing.
class Hdf5Object {
 public:
  Hdf5Object() = default;
  ~Hdf5Object() { close(); }
  Hdf5Object(Hdf5Object&& other) noexcept { swap(other); }
  Hdf5Object& operator=(Hdf5Object&& other) noexcept {
    swap(other);
    return *this;
  }

  bool is_open() const noexcept { return id_ >= 0; }
  bool close() noexcept;

  // Of a file or group; not open if the library could not make it. A dataset is shuffled and
  // deflated in chunks of `chunk` values along each axis.
  Hdf5Object make_group(const std::string& name) const;
  Hdf5Object make_dataset(const std::string& name, ScalarType type,
                          const std::vector<std::uint64_t>& dims,
                          const std::vector<std::uint64_t>& chunk) const;

  // Writes `count` rows, counted along the first axis, from row `first` of a dataset of `type`.
  bool write_rows(std::uint64_t first, std::uint64_t count, ScalarType type,
                  const void* values) const;

  // Attributes that are not there yet; `dims` of the numbers: none for a single one.
  bool add_text(const char* name, const std::string& text) const;
  bool add_numbers(const char* name, ScalarType type, const void* values,
                   const std::vector<std::uint64_t>& dims = {}) const;
  bool add_number(const char* name, std::int64_t value) const {
    return add_numbers(name, ScalarType::kInt64, &value);
  }
  bool add_number(const char* name, double value) const {
    return add_numbers(name, ScalarType::kFloat64, &value);
  }

  // Hands a file's bytes to the system.
  bool flush() const;

 private:
  enum class Kind { kFile, kGroup, kDataset };

  Hdf5Object(std::int64_t id, Kind kind) : id_(id), kind_(kind) {}
  void swap(Hdf5Object& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(kind_, other.kind_);
  }

  friend Hdf5Object make_hdf5_file(const std::string& path);

  std::int64_t id_ = -1;
  Kind kind_ = Kind::kFile;
};

// Throws Error: kUnsupported unless files can be made (the build has HDF5, and the library is
// found), kOutOfMemory unless there is room for it and for packing a chunk of so many bytes.
void require_hdf5(std::size_t chunk_bytes);

// The file at `path`, with nothing in it, in place of what is there; not open if that cannot be.
// Throws Error(kUnsupported) as require_hdf5() does.
Hdf5Object make_hdf5_file(const std::string& path);

}  // namespace ovoid::io
