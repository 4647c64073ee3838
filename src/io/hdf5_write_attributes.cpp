// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5
#include "io/hdf5_write_attributes.h"

#include <algorithm>

#include "io/hdf5_handle.h"

namespace ovoid::io {

hid_t hdf5_native(ScalarType type) {
  switch (type) {
    case ScalarType::kUInt8:
      return H5T_NATIVE_UINT8;
    case ScalarType::kInt8:
      return H5T_NATIVE_INT8;
    case ScalarType::kUInt16:
      return H5T_NATIVE_UINT16;
    case ScalarType::kInt16:
      return H5T_NATIVE_INT16;
    case ScalarType::kUInt32:
      return H5T_NATIVE_UINT32;
    case ScalarType::kInt32:
      return H5T_NATIVE_INT32;
    case ScalarType::kUInt64:
      return H5T_NATIVE_UINT64;
    case ScalarType::kInt64:
      return H5T_NATIVE_INT64;
    case ScalarType::kFloat32:
      return H5T_NATIVE_FLOAT;
    case ScalarType::kFloat64:
      break;
  }
  return H5T_NATIVE_DOUBLE;
}

bool add_hdf5_text(hid_t object, const char* name, const std::string& text) {
  const Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  if (!type.is_open() || !space.is_open() ||
      H5Tset_size(type.get(), std::max<std::size_t>(text.size(), 1)) < 0 ||
      H5Tset_strpad(type.get(), H5T_STR_NULLPAD) < 0 || H5Tset_cset(type.get(), H5T_CSET_UTF8) < 0)
    return false;
  const Hdf5Handle made(H5Acreate2(object, name, type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT),
                        H5Aclose);
  return made.is_open() && H5Awrite(made.get(), type.get(), text.c_str()) >= 0;
}

bool add_hdf5_numbers(hid_t object, const char* name, ScalarType type, const void* values,
                      const std::vector<hsize_t>& dims) {
  const Hdf5Handle space(
      dims.empty() ? H5Screate(H5S_SCALAR)
                   : H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr),
      H5Sclose);
  if (!space.is_open()) return false;
  const Hdf5Handle made(
      H5Acreate2(object, name, hdf5_native(type), space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  return made.is_open() && H5Awrite(made.get(), hdf5_native(type), values) >= 0;
}

}  // namespace ovoid::io
#endif
