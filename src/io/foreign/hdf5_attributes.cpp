// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5
#include "io/foreign/hdf5_attributes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <type_traits>
#include <utility>

#include "data/scalar_visit.h"
#include "io/core/samples.h"
#include "io/core/short_floats.h"
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
  const auto known = type.is_open() ? hdf5_type_of(type.get()) : std::nullopt;
  if (!count || !known) return {};
  Numbers numbers{known->type, std::vector<std::byte>(*count * size_of(known->type))};
  const bool is_short = known->short_float != ShortFloat::kNone;
  std::vector<std::byte> bits(is_short ? 2 * *count : 0);
  std::vector<std::byte>& to = is_short ? bits : numbers.bytes;
  const bool is_converted = known->converted_size > 0;
  if (H5Aread(attribute.get(), is_converted ? hdf5_native_type(known->type) : type.get(),
              to.data()) < 0)
    return {};
  if (!is_converted && known->is_big_endian != (std::endian::native == std::endian::big))
    swap_bytes(to, is_short ? 2 : size_of(known->type));
  if (is_short) widen(bits, known->short_float, numbers.bytes.data());
  return numbers;
}

// Of variable length: the library gives a pointer to each, or none.
std::vector<std::string> read_pointers(hid_t attribute, hid_t type, std::size_t count) {
  std::vector<char*> pointers(count, nullptr);
  if (H5Aread(attribute, type, pointers.data()) < 0) return {};
  std::vector<std::string> texts;
  texts.reserve(count);
  for (const char* const text : pointers)
    texts.push_back(text == nullptr ? "" : std::string(text, ::strnlen(text, kMaxHdf5Text + 1)));
  const Hdf5Handle space(H5Aget_space(attribute), H5Sclose);
  H5Dvlen_reclaim(type, space.get(), H5P_DEFAULT, pointers.data());
  return texts;
}

std::vector<std::string> read_fixed(hid_t attribute, hid_t type, std::size_t count) {
  const std::size_t size = H5Tget_size(type);
  if (size < 1 || size > kMaxHdf5Text) return {};
  std::string all(size * count, '\0');
  if (H5Aread(attribute, type, all.data()) < 0) return {};
  std::vector<std::string> texts;
  const bool has_spaces = H5Tget_strpad(type) == H5T_STR_SPACEPAD;
  for (std::size_t i = 0; i < count; ++i) {
    std::string text = all.substr(i * size, size);
    text.resize(std::min(text.size(), text.find('\0')));
    if (has_spaces) text.resize(text.find_last_not_of(' ') + 1);  // of none: npos + 1 is 0
    texts.push_back(std::move(text));
  }
  return texts;
}

}  // namespace

bool has_hdf5_attribute(hid_t object, const char* name) { return H5Aexists(object, name) > 0; }

std::vector<std::string> hdf5_texts(hid_t object, const char* name, std::size_t most) {
  const Hdf5Handle attribute = open_attribute(object, name);
  if (!attribute.is_open()) return {};
  const auto count = num_elements(attribute.get(), most);
  const Hdf5Handle type(H5Aget_type(attribute.get()), H5Tclose);
  if (!count || !type.is_open() || H5Tget_class(type.get()) != H5T_STRING) return {};
  std::vector<std::string> texts = H5Tis_variable_str(type.get()) > 0
                                       ? read_pointers(attribute.get(), type.get(), *count)
                                       : read_fixed(attribute.get(), type.get(), *count);
  const bool are_short = std::all_of(texts.begin(), texts.end(), [](const std::string& text) {
    return text.size() <= kMaxHdf5Text;
  });
  return are_short ? texts : std::vector<std::string>();
}

std::optional<std::string> hdf5_text(hid_t object, const char* name) {
  std::vector<std::string> texts = hdf5_texts(object, name, 1);
  return texts.size() == 1 ? std::optional(std::move(texts[0])) : std::nullopt;
}

std::optional<std::string> hdf5_joined_text(hid_t object, const char* name) {
  const std::vector<std::string> texts = hdf5_texts(object, name, kMaxHdf5Text);
  if (texts.empty()) return std::nullopt;
  std::string joined;
  for (const std::string& text : texts) joined += text;
  return joined;
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

CfAttributes hdf5_cf_attributes(hid_t object) {
  constexpr std::size_t kMost = 64;  // texts or numbers of one
  CfAttributes attributes;
  for (const char* const name : kCfAttributes) {
    if (!has_hdf5_attribute(object, name)) continue;
    CfAttribute attribute{.name = name};
    if (const auto texts = hdf5_texts(object, name, kMost); !texts.empty())
      attribute.text = texts[0];
    if (attribute.text.empty()) {
      attribute.numbers = hdf5_numbers(object, name, kMost);
      const Hdf5Handle type(H5Aget_type(open_attribute(object, name).get()), H5Tclose);
      if (const auto known = hdf5_type_of(type.get())) attribute.type = known->type;
    }
    attributes.push_back(std::move(attribute));
  }
  return attributes;
}

}  // namespace ovoid::io
#endif
