// SPDX-License-Identifier: Apache-2.0
// Which types of HDF5 files are numbers, and what these become.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <optional>
#include <string>

#include "io/core/short_floats.h"
#include "ovoid/lattice.h"

namespace ovoid::io {

// A type of numbers as files have it, and what they become.
struct Hdf5Type {
  ScalarType type;  // in memory
  bool is_big_endian = false;
  ShortFloat short_float = ShortFloat::kNone;  // of the file's numbers, which are widened
  std::int64_t converted_size = 0;  // bytes in the file of what the library converts; else 0
  bool is_boolean = false;

  std::int64_t stored_size() const noexcept;  // bytes of a number in the file
};

// Integers of 1 to 8 bytes and IEEE floats of 4 and 8, in either byte order, are what they are; so
// are enumerations of integers, whose numbers count, and bit fields, which are unsigned. Floats of
// 16 bits become float32; integers that fill their bytes in part and floats of other kinds (of 80
// or 128 bits) the next type that holds them, at most float64. Nothing for a type that is no
// number.
std::optional<Hdf5Type> hdf5_type_of(hid_t type);

// What it is, for messages: "float16", "booleans", "compound (r, i): complex numbers", "text".
std::string hdf5_type_text(hid_t type);

// What the numbers of `where` became, where that is another type, for Dataset::notes; else empty.
std::string hdf5_type_note(const std::string& where, const Hdf5Type& type);

// The library's own type of such numbers in memory.
hid_t hdf5_native_type(ScalarType type);

}  // namespace ovoid::io
