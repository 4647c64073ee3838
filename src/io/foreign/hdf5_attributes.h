// SPDX-License-Identifier: Apache-2.0
// Attributes of objects in HDF5 files, read: numbers and short text.
#pragma once

#include <hdf5.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "io/core/cf_conventions.h"
#include "ovoid/lattice.h"

namespace ovoid::io {

bool has_hdf5_attribute(hid_t object, const char* name);

// One text, of a fixed length or a variable one, without what pads it; nothing for anything
// else, or for longer text than kMaxHdf5Text.
std::optional<std::string> hdf5_text(hid_t object, const char* name);

// The texts of an attribute that has several, or one; empty for anything else, or for more than
// `most`.
std::vector<std::string> hdf5_texts(hid_t object, const char* name, std::size_t most);

// One text, or the characters that a list of them has (Imaris writes them so); nothing for anything
// else.
std::optional<std::string> hdf5_joined_text(hid_t object, const char* name);

// Numbers of up to two axes, at most `most` of them; empty for anything else. Of every type that
// hdf5_type_of() knows.
std::vector<double> hdf5_numbers(hid_t object, const char* name, std::size_t most);

// A single number as it is stored; empty for anything else.
struct Hdf5Number {
  ScalarType type = ScalarType::kUInt8;
  std::vector<std::byte> bytes;  // native byte order
};
std::optional<Hdf5Number> hdf5_number(hid_t object, const char* name);

// Those of kCfAttributes that it has; of several texts the first.
CfAttributes hdf5_cf_attributes(hid_t object);

}  // namespace ovoid::io
