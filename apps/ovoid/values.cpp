// SPDX-License-Identifier: Apache-2.0
#include "values.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string_view>
#include <system_error>

#include "color_words.h"
#include "ovoid/io.h"
#include "ovoid/space_part.h"

namespace ovoid::cli {
namespace {

// The whole text as a number of type T, or nothing. std::from_chars does not depend on the locale.
template <typename T>
std::optional<T> whole(const std::string& text) {
  const char* begin = text.data();
  const char* const end = begin + text.size();
  if (end - begin > 1 && *begin == '+' && begin[1] != '-') ++begin;
  T value{};
  const auto [stop, error] = std::from_chars(begin, end, value);
  if (error != std::errc() || stop != end) return std::nullopt;
  return value;
}

std::optional<double> finite(const std::string& text) {
  const std::optional<double> value = whole<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::string describe(const Interval& interval) {
  const bool has_lo = std::isfinite(interval.lo);
  const bool has_hi = std::isfinite(interval.hi);
  const char* const above = interval.lo_open ? ">" : ">=";
  const char* const below = interval.hi_open ? "<" : "<=";
  if (has_lo && has_hi) {
    return fmt::format("a number {} {:g} and {} {:g}", above, interval.lo, below, interval.hi);
  }
  if (has_lo) return fmt::format("a number {} {:g}", above, interval.lo);
  if (has_hi) return fmt::format("a number {} {:g}", below, interval.hi);
  return "a number";
}

bool is_inside(const Interval& interval, double value) {
  const bool above = interval.lo_open ? value > interval.lo : value >= interval.lo;
  const bool below = interval.hi_open ? value < interval.hi : value <= interval.hi;
  return above && below;
}

constexpr std::array<ScalarType, 10> kScalarTypes = {
    ScalarType::kUInt8,   ScalarType::kInt8,   ScalarType::kUInt16, ScalarType::kInt16,
    ScalarType::kUInt32,  ScalarType::kInt32,  ScalarType::kUInt64, ScalarType::kInt64,
    ScalarType::kFloat32, ScalarType::kFloat64};

}  // namespace

bool is_json(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  return first != std::string::npos && (text[first] == '{' || text[first] == '[');
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t end = 0; end != std::string::npos; begin = end + 1) {
    end = text.find(separator, begin);
    parts.push_back(text.substr(begin, end == std::string::npos ? end : end - begin));
  }
  return parts;
}

double parse_number(const std::string& text, const Interval& interval) {
  const std::optional<double> value = finite(text);
  if (!value || !is_inside(interval, *value)) throw BadValue("expected " + describe(interval));
  return *value;
}

std::int64_t parse_integer(const std::string& text, std::int64_t lo, std::int64_t hi) {
  const std::optional<std::int64_t> value = whole<std::int64_t>(text);
  if (!value || *value < lo || *value > hi) {
    throw BadValue(fmt::format("expected a whole number from {} to {}", lo, hi));
  }
  return *value;
}

std::uint64_t parse_seed(const std::string& text) {
  const std::optional<std::uint64_t> value = whole<std::uint64_t>(text);
  if (!value) throw BadValue("expected a whole number >= 0");
  return *value;
}

std::vector<double> parse_numbers(const std::string& text, std::size_t count) {
  std::vector<double> numbers;
  for (const std::string& part : split(text, ',')) {
    const std::optional<double> value = finite(part);
    if (!value) break;
    numbers.push_back(*value);
  }
  if (numbers.size() != count || split(text, ',').size() != count) {
    throw BadValue(fmt::format("expected {} numbers, separated by commas", count));
  }
  return numbers;
}

Rgb parse_rgb(const std::string& text) {
  const bool may_be_name = !text.empty() && std::isalpha(static_cast<unsigned char>(text[0])) != 0;
  if (text.starts_with('#') || (may_be_name && text.find(',') == std::string::npos))
    return color_of_word(text);
  const std::vector<double> rgb = parse_numbers(text, 3);
  const auto [least, greatest] = std::minmax_element(rgb.begin(), rgb.end());
  if (*least < 0 || *greatest > 1) throw BadValue("expected three numbers in [0, 1]");
  return {rgb[0], rgb[1], rgb[2]};
}

Vec3 parse_vec3(const std::string& text) {
  const std::vector<double> numbers = parse_numbers(text, 3);
  return {numbers[0], numbers[1], numbers[2]};
}

std::pair<double, double> parse_range(const std::string& text) {
  const std::vector<double> numbers = parse_numbers(text, 2);
  if (!(numbers[0] < numbers[1])) throw BadValue("expected LO,HI with LO < HI");
  if (!std::isfinite(numbers[1] - numbers[0]))
    throw BadValue("expected LO,HI whose difference a double can hold");
  return {numbers[0], numbers[1]};
}

std::pair<int, int> parse_size(const std::string& text, int greatest) {
  const std::vector<std::string> parts = split(text, 'x');
  std::vector<int> sides;
  for (const std::string& part : parts) {
    const std::optional<int> side = whole<int>(part);
    if (side && *side >= 1 && *side <= greatest) sides.push_back(*side);
  }
  if (parts.size() != 2 || sides.size() != 2) {
    throw BadValue(fmt::format("expected WIDTHxHEIGHT, each 1 to {}", greatest));
  }
  return {sides[0], sides[1]};
}

PartChoice parse_part(const std::string& text) {
  const std::vector<std::string> parts = split(text, '/');
  if (parts.size() == 2) {
    const std::optional<int> number = whole<int>(parts[0]);
    const std::optional<int> count = whole<int>(parts[1]);
    if (number && count && 1 <= *number && *number <= *count && *count <= kMostParts)
      return {*number, *count};
  }
  throw BadValue(fmt::format("expected K/N: part K of N, 1 <= K <= N <= {}", kMostParts));
}

Index3 parse_dims(const std::string& text) {
  const std::vector<std::string> parts = split(text, 'x');
  std::vector<std::int64_t> sides;
  for (const std::string& part : parts) {
    const std::optional<std::int64_t> side = whole<std::int64_t>(part);
    if (side && *side >= 1) sides.push_back(*side);
  }
  if (parts.size() != 3 || sides.size() != 3) {
    throw BadValue("expected XxYxZ, each a whole number >= 1");
  }
  return {sides[0], sides[1], sides[2]};
}

std::size_t parse_bytes(const std::string& text) {
  const std::string units = "KMG";
  const std::size_t unit = text.empty() ? std::string::npos : units.find(text.back());
  const bool has_unit = unit != std::string::npos;
  const std::optional<std::int64_t> count =
      whole<std::int64_t>(has_unit ? text.substr(0, text.size() - 1) : text);
  const std::int64_t factor = has_unit ? std::int64_t{1024} << 10 * unit : 1;
  if (!count || *count < 1 || *count > (std::int64_t{1} << 50) / factor)
    throw BadValue("expected a number of bytes, such as 4G or 512M");
  return static_cast<std::size_t>(*count * factor);
}

ScalarType parse_scalar_type(const std::string& text) {
  if (const auto type = find_scalar_type(text)) return *type;
  std::string known;
  for (const ScalarType type : kScalarTypes) {
    known += (known.empty() ? "" : ", ") + std::string(name_of(type));
  }
  throw BadValue("expected one of " + known);
}

}  // namespace ovoid::cli
