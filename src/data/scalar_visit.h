// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "ovoid/lattice.h"

namespace ovoid::data {

// Calls visitor(std::type_identity<T>{}) with the C++ type that `type` names and returns its
// result. The ten instances of the visitor must return the same type.
template <class Visitor>
decltype(auto) visit_scalar(ScalarType type, Visitor&& visitor) {
  switch (type) {
    case ScalarType::kUInt8:
      return visitor(std::type_identity<std::uint8_t>{});
    case ScalarType::kInt8:
      return visitor(std::type_identity<std::int8_t>{});
    case ScalarType::kUInt16:
      return visitor(std::type_identity<std::uint16_t>{});
    case ScalarType::kInt16:
      return visitor(std::type_identity<std::int16_t>{});
    case ScalarType::kUInt32:
      return visitor(std::type_identity<std::uint32_t>{});
    case ScalarType::kInt32:
      return visitor(std::type_identity<std::int32_t>{});
    case ScalarType::kUInt64:
      return visitor(std::type_identity<std::uint64_t>{});
    case ScalarType::kInt64:
      return visitor(std::type_identity<std::int64_t>{});
    case ScalarType::kFloat32:
      return visitor(std::type_identity<float>{});
    case ScalarType::kFloat64:
      break;
  }
  return visitor(std::type_identity<double>{});
}

// The value of type T at `bytes + index * sizeof(T)`, which need not be aligned: files put arrays
// anywhere.
template <class T>
T load_scalar(const std::byte* bytes, std::int64_t index) noexcept {
  T value;
  std::memcpy(&value, bytes + static_cast<std::size_t>(index) * sizeof(T), sizeof(T));
  return value;
}

}  // namespace ovoid::data
