// SPDX-License-Identifier: Apache-2.0
// What chunks of HDF5 files went through before they were written. The library undoes deflate,
// shuffle, Fletcher's checksum, szip, n-bit and scale-offset; the filters that others have
// registered [HDF5 filters] and that are undone here are LZF (h5py), bzip2 and Blosc (PyTables),
// LZ4, bitshuffle and Zstandard.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <string>

namespace ovoid::io {

// Makes the library undo them; again and again does nothing.
void use_hdf5_filters();

// How many bytes a byte of chunks that went through these filters can stand for, at most. Throws
// Error(kUnsupported), naming the filter and a way out, if one of them is not undone here.
std::int64_t check_hdf5_filters(hid_t creation, const std::string& where);

// While it lives, chunks of this dataset are unpacked, none to more than its size.
class Hdf5Unpacking {
 public:
  Hdf5Unpacking(hid_t dataset, std::int64_t item_size);
  ~Hdf5Unpacking();
  Hdf5Unpacking(const Hdf5Unpacking&) = delete;
  Hdf5Unpacking& operator=(const Hdf5Unpacking&) = delete;

  // What a filter said of a chunk that it could not undo; empty if none did.
  static const std::string& error() noexcept;
};

}  // namespace ovoid::io
