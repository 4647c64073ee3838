// SPDX-License-Identifier: Apache-2.0
#include "io/core/missing_numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

#include "data/scalar_visit.h"
#include "io/core/memory.h"
#include "io/core/samples.h"

namespace ovoid::io {
namespace {

// The numbers as the type holds them; those that it does not hold are no sample.
template <typename T>
std::vector<T> numbers_as(std::span<const double> numbers) {
  std::vector<T> result;
  for (const double number : numbers) {
    if constexpr (std::is_floating_point_v<T>) {
      if (std::abs(number) <= static_cast<double>(std::numeric_limits<T>::max()))
        result.push_back(static_cast<T>(number));
    } else if (number >= static_cast<double>(std::numeric_limits<T>::lowest()) &&
               number < std::ldexp(1.0, std::numeric_limits<T>::digits) &&
               number == std::floor(number)) {
      result.push_back(static_cast<T>(number));
    }
  }
  return result;
}

template <typename T, typename Value>
Bytes without_missing(std::span<const std::byte> bytes, const std::vector<T>& missing) {
  SampleBuffer buffer;
  const std::size_t count = bytes.size() / sizeof(T);
  const auto size = static_cast<std::int64_t>(count * sizeof(Value));
  std::byte* const to = buffer.extend(size, size).data();
  for (std::size_t i = 0; i < count; ++i) {
    T sample;
    std::memcpy(&sample, bytes.data() + i * sizeof(T), sizeof(T));
    const bool is_missing = std::find(missing.begin(), missing.end(), sample) != missing.end();
    const Value value =
        is_missing ? std::numeric_limits<Value>::quiet_NaN() : static_cast<Value>(sample);
    std::memcpy(to + i * sizeof(Value), &value, sizeof(Value));
  }
  return buffer.release();
}

template <typename T>
bool holds_one_of(std::span<const std::byte> bytes, const std::vector<T>& missing) {
  for (std::size_t at = 0; at + sizeof(T) <= bytes.size(); at += sizeof(T)) {
    T sample;
    std::memcpy(&sample, bytes.data() + at, sizeof(T));
    if (std::find(missing.begin(), missing.end(), sample) != missing.end()) return true;
  }
  return false;
}

}  // namespace

void hide_missing_numbers(const std::string& where, std::span<const double> numbers,
                          DataArray& array, std::vector<std::string>& notes) {
  data::visit_scalar(array.type, [&]<class T>(std::type_identity<T>) {
    const std::vector<T> missing = numbers_as<T>(numbers);
    if (missing.empty() || !holds_one_of(array.bytes.view, missing)) return;
    constexpr bool is_wide = sizeof(T) >= 4 && !std::is_same_v<T, float>;
    using Value = std::conditional_t<is_wide, double, float>;
    require_memory(where,
                   static_cast<std::int64_t>(array.bytes.view.size() / sizeof(T) * sizeof(Value)));
    array.bytes = without_missing<T, Value>(array.bytes.view, missing);
    const ScalarType stored = array.type;
    array.type = is_wide ? ScalarType::kFloat64 : ScalarType::kFloat32;
    if (array.type == stored) return;
    notes.push_back(fmt::format("{}: {} becomes {}: {} stands for missing samples", where,
                                name_of(stored), name_of(array.type),
                                static_cast<double>(missing.front())));
  });
}

std::optional<std::pair<double, double>> even_places(std::span<const double> places) {
  if (places.size() < 2) return std::nullopt;
  const double step = (places.back() - places.front()) / static_cast<double>(places.size() - 1);
  if (!std::isfinite(step) || step == 0) return std::nullopt;
  constexpr double kUneven = 1e-3;  // of a step; coordinates are often float32
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double even = places[0] + static_cast<double>(i) * step;
    if (!(std::abs(places[i] - even) <= kUneven * std::abs(step))) return std::nullopt;
  }
  return std::pair(places[0], step);
}

}  // namespace ovoid::io
