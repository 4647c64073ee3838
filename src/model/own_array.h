// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "ovoid/dataset.h"

namespace ovoid::model {

// An array that owns its numbers.
template <class T>
DataArray array_of_numbers(std::string name, int components, std::vector<T> numbers) {
  constexpr bool is_float = std::is_same_v<T, float>, is_double = std::is_same_v<T, double>;
  static_assert(is_float || is_double || std::is_same_v<T, std::uint8_t>);
  const auto owner = std::make_shared<const std::vector<T>>(std::move(numbers));
  DataArray array;
  array.name = std::move(name);
  array.type = is_float    ? ScalarType::kFloat32
               : is_double ? ScalarType::kFloat64
                           : ScalarType::kUInt8;
  array.num_components = components;
  array.num_tuples = static_cast<std::int64_t>(owner->size()) / components;
  array.bytes = {owner, std::as_bytes(std::span<const T>(*owner))};
  return array;
}

}  // namespace ovoid::model
