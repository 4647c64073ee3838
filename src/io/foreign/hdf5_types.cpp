// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5
#include "io/foreign/hdf5_types.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "io/foreign/hdf5_handle.h"

namespace ovoid::io {
namespace {

std::optional<Hdf5Type> plain_type(hid_t type) {
  const std::array<std::pair<hid_t, Hdf5Type>, 20> types{{
      {H5T_IEEE_F32LE, {ScalarType::kFloat32, false}},
      {H5T_IEEE_F32BE, {ScalarType::kFloat32, true}},
      {H5T_IEEE_F64LE, {ScalarType::kFloat64, false}},
      {H5T_IEEE_F64BE, {ScalarType::kFloat64, true}},
      {H5T_STD_U8LE, {ScalarType::kUInt8, false}},
      {H5T_STD_U8BE, {ScalarType::kUInt8, true}},
      {H5T_STD_I8LE, {ScalarType::kInt8, false}},
      {H5T_STD_I8BE, {ScalarType::kInt8, true}},
      {H5T_STD_U16LE, {ScalarType::kUInt16, false}},
      {H5T_STD_U16BE, {ScalarType::kUInt16, true}},
      {H5T_STD_I16LE, {ScalarType::kInt16, false}},
      {H5T_STD_I16BE, {ScalarType::kInt16, true}},
      {H5T_STD_U32LE, {ScalarType::kUInt32, false}},
      {H5T_STD_U32BE, {ScalarType::kUInt32, true}},
      {H5T_STD_I32LE, {ScalarType::kInt32, false}},
      {H5T_STD_I32BE, {ScalarType::kInt32, true}},
      {H5T_STD_U64LE, {ScalarType::kUInt64, false}},
      {H5T_STD_U64BE, {ScalarType::kUInt64, true}},
      {H5T_STD_I64LE, {ScalarType::kInt64, false}},
      {H5T_STD_I64BE, {ScalarType::kInt64, true}},
  }};
  for (const auto& [known, result] : types)
    if (H5Tequal(type, known) > 0) return result;
  return std::nullopt;
}

// The integer type of so many bytes, or the next one that holds them; nothing above 8.
std::optional<ScalarType> integer_of(std::size_t num_bytes, bool is_signed) {
  static constexpr std::array<std::array<ScalarType, 2>, 4> kTypes{
      {{ScalarType::kUInt8, ScalarType::kInt8},
       {ScalarType::kUInt16, ScalarType::kInt16},
       {ScalarType::kUInt32, ScalarType::kInt32},
       {ScalarType::kUInt64, ScalarType::kInt64}}};
  for (std::size_t i = 0; i < kTypes.size(); ++i)
    if (num_bytes <= std::size_t{1} << i) return kTypes[i][is_signed ? 1 : 0];
  return std::nullopt;
}

// Where the parts of a 16-bit float lie: the sign, the exponent and the fraction, by their first
// bits and sizes, and the exponent's bias.
struct FloatParts {
  std::size_t sign = 0, exponent = 0, exponent_size = 0, fraction = 0, fraction_size = 0, bias = 0;
  friend bool operator==(const FloatParts&, const FloatParts&) = default;
};

ShortFloat short_float_of(hid_t type) {
  FloatParts parts;
  if (H5Tget_size(type) != 2 || H5Tget_precision(type) != 16 || H5Tget_offset(type) != 0 ||
      H5Tget_fields(type, &parts.sign, &parts.exponent, &parts.exponent_size, &parts.fraction,
                    &parts.fraction_size) < 0)
    return ShortFloat::kNone;
  parts.bias = H5Tget_ebias(type);
  if (parts == FloatParts{15, 10, 5, 0, 10, 15}) return ShortFloat::kHalf;
  if (parts == FloatParts{15, 7, 8, 0, 7, 127}) return ShortFloat::kBrain;
  return ShortFloat::kNone;
}

std::optional<Hdf5Type> float_type(hid_t type) {
  const H5T_order_t order = H5Tget_order(type);
  const std::size_t size = H5Tget_size(type);
  const bool is_ordered = order == H5T_ORDER_LE || order == H5T_ORDER_BE;
  if (const ShortFloat kind = short_float_of(type); is_ordered && kind != ShortFloat::kNone)
    return Hdf5Type{ScalarType::kFloat32, order == H5T_ORDER_BE, kind};
  constexpr std::size_t kMost = 16;
  if (size > kMost) return std::nullopt;
  return Hdf5Type{size <= 2 ? ScalarType::kFloat32 : ScalarType::kFloat64, false, ShortFloat::kNone,
                  static_cast<std::int64_t>(size)};
}

std::optional<Hdf5Type> integer_type(hid_t type) {
  const std::size_t size = H5Tget_size(type);
  const auto holds = integer_of(size, H5Tget_sign(type) == H5T_SGN_2);
  if (!holds) return std::nullopt;
  return Hdf5Type{*holds, false, ShortFloat::kNone, static_cast<std::int64_t>(size)};
}

std::optional<Hdf5Type> bit_field_type(hid_t type) {
  const std::size_t size = H5Tget_size(type);
  const auto holds = integer_of(size, false);
  const H5T_order_t order = H5Tget_order(type);
  if (!holds || size != size_of(*holds) || H5Tget_precision(type) != 8 * size ||
      (order != H5T_ORDER_LE && order != H5T_ORDER_BE))
    return std::nullopt;
  return Hdf5Type{*holds, order == H5T_ORDER_BE};
}

std::string member_name(hid_t type, unsigned index) {
  char* const name = H5Tget_member_name(type, index);
  if (name == nullptr) return "";
  std::string text(name);
  H5free_memory(name);
  return text;
}

// h5py's: the names FALSE and TRUE for 0 and 1, of one byte.
bool is_boolean(hid_t type) {
  if (H5Tget_size(type) != 1 || H5Tget_nmembers(type) != 2) return false;
  for (unsigned i = 0; i < 2; ++i) {
    const std::string name = member_name(type, i);
    signed char value = -1;
    if (H5Tget_member_value(type, i, &value) < 0) return false;
    if (!(name == "FALSE" && value == 0) && !(name == "TRUE" && value == 1)) return false;
  }
  return true;
}

std::optional<Hdf5Type> enumeration_type(hid_t type) {
  if (is_boolean(type)) {
    Hdf5Type boolean{ScalarType::kUInt8};
    boolean.is_boolean = true;
    return boolean;
  }
  const Hdf5Handle base(H5Tget_super(type), H5Tclose);
  auto known = base.is_open() ? plain_type(base.get()) : std::nullopt;
  return known && !is_floating(known->type) ? known : std::nullopt;
}

std::string compound_text(hid_t type) {
  constexpr int kListed = 6;
  constexpr std::size_t kMostLetters = 40;
  const int count = H5Tget_nmembers(type);
  std::string names;
  for (int i = 0; i < std::min(count, kListed); ++i)
    names += (names.empty() ? "" : ", ") +
             member_name(type, static_cast<unsigned>(i)).substr(0, kMostLetters);
  const bool is_complex =
      names == "r, i" || names == "real, imag" || names == "re, im" || names == "real, imaginary";
  return fmt::format("compound ({}{}){}", names, count > kListed ? ", ..." : "",
                     is_complex ? ": complex numbers" : "");
}

}  // namespace

std::int64_t Hdf5Type::stored_size() const noexcept {
  return converted_size > 0                 ? converted_size
         : short_float != ShortFloat::kNone ? 2
                                            : static_cast<std::int64_t>(size_of(type));
}

std::optional<Hdf5Type> hdf5_type_of(hid_t type) {
  if (auto plain = plain_type(type)) return plain;
  switch (H5Tget_class(type)) {
    case H5T_FLOAT:
      return float_type(type);
    case H5T_INTEGER:
      return integer_type(type);
    case H5T_BITFIELD:
      return bit_field_type(type);
    case H5T_ENUM:
      return enumeration_type(type);
    default:
      return std::nullopt;
  }
}

std::string hdf5_type_text(hid_t type) {
  const std::size_t bits = 8 * H5Tget_size(type);
  switch (H5Tget_class(type)) {
    case H5T_FLOAT:
      return fmt::format("floats of {} bits", bits);
    case H5T_INTEGER:
      return fmt::format("integers of {} bits", bits);
    case H5T_BITFIELD:
      return fmt::format("bit fields of {} bits", bits);
    case H5T_ENUM:
      return is_boolean(type) ? "booleans" : "an enumeration";
    case H5T_COMPOUND:
      return compound_text(type);
    case H5T_STRING:
      return "text";
    case H5T_REFERENCE:
      return "references";
    case H5T_ARRAY: {
      const Hdf5Handle base(H5Tget_super(type), H5Tclose);
      return "arrays of " + (base.is_open() ? hdf5_type_text(base.get()) : std::string("nothing"));
    }
    case H5T_VLEN:
      return "lists of any length";
    case H5T_OPAQUE:
      return "opaque bytes";
    default:
      return "a type of no known kind";
  }
}

std::string hdf5_type_note(const std::string& where, const Hdf5Type& type) {
  const std::string stored = type.is_boolean                         ? "booleans"
                             : type.short_float != ShortFloat::kNone ? name_of(type.short_float)
                             : type.converted_size == 0              ? ""
                             : is_floating(type.type)
                                 ? fmt::format("floats of {} bytes", type.converted_size)
                                 : fmt::format("integers within {} bytes", type.converted_size);
  if (stored.empty()) return "";
  return fmt::format("{}: {} become {}", where, stored, name_of(type.type));
}

hid_t hdf5_native_type(ScalarType type) {
  const std::array types{H5T_NATIVE_UINT8,  H5T_NATIVE_INT8,  H5T_NATIVE_UINT16, H5T_NATIVE_INT16,
                         H5T_NATIVE_UINT32, H5T_NATIVE_INT32, H5T_NATIVE_UINT64, H5T_NATIVE_INT64,
                         H5T_NATIVE_FLOAT,  H5T_NATIVE_DOUBLE};
  return types[static_cast<std::size_t>(type)];
}

}  // namespace ovoid::io
#endif
