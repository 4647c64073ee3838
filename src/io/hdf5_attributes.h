// SPDX-License-Identifier: Apache-2.0
// Attributes of objects in HDF5 files: numbers and short text.
#pragma once

#include <hdf5.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ovoid/lattice.h"

namespace ovoid::io {

// No text that is read or written is longer, bytes.
inline constexpr std::size_t kMaxHdf5Text = 4096;

bool has_hdf5_attribute(hid_t object, const char* name);

// Text of a fixed length, as it is written here; that of variable length lies elsewhere in the
// file, where the library would believe every size. Without trailing zeros; empty optional for
// anything else, or longer text.
std::optional<std::string> hdf5_text(hid_t object, const char* name);

// Numbers of up to two axes, at most `most` of them; empty for anything else.
std::vector<double> hdf5_numbers(hid_t object, const char* name, std::size_t most);

// A single number as it is stored; empty for anything else.
struct Hdf5Number {
  ScalarType type = ScalarType::kUInt8;
  std::vector<std::byte> bytes;  // native byte order
};
std::optional<Hdf5Number> hdf5_number(hid_t object, const char* name);

// The type in memory.
hid_t hdf5_native(ScalarType type);

// Make an attribute that is not there yet; `dims` of the numbers: none for a single one. False if
// the library cannot.
bool add_hdf5_text(hid_t object, const char* name, const std::string& text);
bool add_hdf5_numbers(hid_t object, const char* name, ScalarType type, const void* values,
                      const std::vector<hsize_t>& dims = {});
inline bool add_hdf5_number(hid_t object, const char* name, std::int64_t value) {
  return add_hdf5_numbers(object, name, ScalarType::kInt64, &value);
}
inline bool add_hdf5_number(hid_t object, const char* name, double value) {
  return add_hdf5_numbers(object, name, ScalarType::kFloat64, &value);
}

}  // namespace ovoid::io
