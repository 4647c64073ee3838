// SPDX-License-Identifier: Apache-2.0
// Attributes of objects in HDF5 files, read: numbers and short text.
#pragma once

#include <hdf5.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "ovoid/lattice.h"

namespace ovoid::io {

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

}  // namespace ovoid::io
