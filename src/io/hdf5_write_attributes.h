// SPDX-License-Identifier: Apache-2.0
// Attributes of objects in HDF5 files, written: numbers and short text.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <string>
#include <vector>

#include "ovoid/lattice.h"

namespace ovoid::io {

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
