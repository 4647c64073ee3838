// SPDX-License-Identifier: Apache-2.0
// Numbers as files hold them: as text, and as bytes in either order.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>
#include <system_error>

namespace ovoid::io {

// The number that is the whole text, in no locale's way and without a plus sign; nothing if there
// is none, or it does not fit T. `base`: of integers, for std::from_chars.
template <typename T, typename... Base>
std::optional<T> exact_number(std::string_view text, Base... base) noexcept {
  T value{};
  const char* const end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, value, base...);
  if (result.ec != std::errc{} || result.ptr != end) return std::nullopt;
  return value;
}

// The same; a plus sign may stand before it, which C++ streams read, and so VTK does.
template <typename T>
std::optional<T> parse_number(std::string_view text) noexcept {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  return exact_number<T>(text);
}

inline std::optional<std::int64_t> parse_integer(std::string_view text) noexcept {
  return parse_number<std::int64_t>(text);
}

// A finite number.
inline std::optional<double> parse_real(std::string_view text) noexcept {
  const auto value = parse_number<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

template <typename T>
T swapped(T value) noexcept {
  auto bytes = std::bit_cast<std::array<std::byte, sizeof(T)>>(value);
  std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<T>(bytes);
}

// The number in the sizeof(T) bytes at `bytes`.
template <typename T>
T number_at(const void* bytes, bool is_big_endian) noexcept {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return is_big_endian == (std::endian::native == std::endian::big) ? value : swapped(value);
}

// The number of all these bytes, at most 8 of them.
inline std::uint64_t unsigned_of(std::string_view bytes, bool is_big_endian) noexcept {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i)
    value =
        value << 8U | static_cast<unsigned char>(bytes[is_big_endian ? i : bytes.size() - 1 - i]);
  return value;
}

}  // namespace ovoid::io
