// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5
#include "io/foreign/hdf5_attributes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <type_traits>

#include "data/scalar_visit.h"
#include "io/core/samples.h"
#include "io/foreign/hdf5_handle.h"
#include "io/foreign/hdf5_storage.h"
#include "io/hdf5/hdf5_lattice_format.h"

namespace ovoid::io {
namespace {

Hdf5Handle open_attribute(hid_t object, const char* name) {
  if (!has_hdf5_attribute(object, name)) return {};
  return {H5Aopen(object, name, H5P_DEFAULT), H5Aclose};
}

// Nothing if there are more than `most`, more than two axes, or none.
std::optional<std::size_t> num_elements(hid_t attribute, std::size_t most) {
  const Hdf5Handle space(H5Aget_space(attribute), H5Sclose);
  if (!space.is_open() || H5Sget_simple_extent_type(space.get()) == H5S_NULL) return std::nullopt;
  const int rank = H5Sget_simple_extent_ndims(space.get());
  if (rank < 0 || rank > 2) return std::nullopt;
  std::array<hsize_t, 2> dims{1, 1};
  if (rank > 0 && H5Sget_simple_extent_dims(space.get(), dims.data(), nullptr) < 0)
    return std::nullopt;
  if (dims[0] < 1 || dims[1] < 1 || dims[0] > most || dims[1] > most / dims[0]) return std::nullopt;
  return static_cast<std::size_t>(dims[0] * dims[1]);
}

// Several of one type, behind each other; no bytes if there are none.
using Numbers = Hdf5Number;

Numbers read_numbers(hid_t object, const char* name, std::size_t most) {
  const Hdf5Handle attribute = open_attribute(object, name);
  if (!attribute.is_open()) return {};
  const Hdf5Handle type(H5Aget_type(attribute.get()), H5Tclose);
  const auto count = num_elements(attribute.get(), most);
  const auto known = hdf5_type_of(type.get());
  if (!count || !known) return {};
  // As they are: no conversion by the library.
  Numbers numbers{known->type, std::vector<std::byte>(*count * size_of(known->type))};
  if (H5Aread(attribute.get(), type.get(), numbers.bytes.data()) < 0) return {};
  if (known->is_big_endian != (std::endian::native == std::endian::big))
    swap_bytes(numbers.bytes, size_of(known->type));
  return numbers;
}

}  // namespace

bool has_hdf5_attribute(hid_t object, const char* name) { return H5Aexists(object, name) > 0; }

std::optional<std::string> hdf5_text(hid_t object, const char* name) {
  const Hdf5Handle attribute = open_attribute(object, name);
  if (!attribute.is_open() || num_elements(attribute.get(), 1) != 1) return std::nullopt;
  const Hdf5Handle type(H5Aget_type(attribute.get()), H5Tclose);
  if (!type.is_open() || H5Tget_class(type.get()) != H5T_STRING ||
      H5Tis_variable_str(type.get()) != 0)
    return std::nullopt;
  const std::size_t size = H5Tget_size(type.get());
  if (size < 1 || size > kMaxHdf5Text) return std::nullopt;
  std::string text(size, '\0');
  if (H5Aread(attribute.get(), type.get(), text.data()) < 0) return std::nullopt;
  text.resize(std::min(text.size(), text.find('\0')));
  return text;
}

std::vector<double> hdf5_numbers(hid_t object, const char* name, std::size_t most) {
  const Numbers numbers = read_numbers(object, name, most);
  return data::visit_scalar(numbers.type, [&]<class T>(std::type_identity<T>) {
    std::vector<double> values;
    for (std::size_t i = 0; i < numbers.bytes.size() / sizeof(T); ++i)
      values.push_back(static_cast<double>(
          data::load_scalar<T>(numbers.bytes.data(), static_cast<std::int64_t>(i))));
    return values;
  });
}

std::optional<Hdf5Number> hdf5_number(hid_t object, const char* name) {
  Hdf5Number number = read_numbers(object, name, 1);
  if (number.bytes.empty()) return std::nullopt;
  return number;
}

}  // namespace ovoid::io
#endif
