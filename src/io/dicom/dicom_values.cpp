// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "io/core/numbers.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

std::string_view without_padding(std::string_view text) noexcept {
  constexpr std::string_view kPadding(" \0\t\r\n", 5);
  const auto first = text.find_first_not_of(kPadding);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kPadding) - first + 1);
}

// The number that `count` digits from `at` are; nothing if there are none such.
std::optional<int> digits_at(std::string_view text, std::size_t at, std::size_t count) noexcept {
  if (text.size() < at + count) return std::nullopt;
  int value = 0;
  for (const char c : text.substr(at, count)) {
    if (c < '0' || c > '9') return std::nullopt;
    value = 10 * value + (c - '0');
  }
  return value;
}

}  // namespace

void DicomValues::fail(const DicomElement& element, const std::string& what) const {
  throw Error(ErrorCode::kFileFormat,
              fmt::format("{}: {}: {}", source_.name(), tag_text(element.tag), what));
}

void DicomValues::fail_count(const DicomElement& element, std::size_t count,
                             std::size_t expected) const {
  fail(element, fmt::format("{} numbers: expected {}", count, expected));
}

std::string DicomValues::text(const DicomElement& element, std::int64_t limit) const {
  if (element.length > limit)
    fail(element, fmt::format("{} bytes: expected at most {}", element.length, limit));
  return std::string(without_padding(source_.text(element.offset, element.length)));
}

std::int64_t DicomValues::integer(const DicomElement& element) const {
  const std::string bytes = source_.text(element.offset, std::min<std::int64_t>(element.length, 4));
  if (bytes.size() != 2 && bytes.size() != 4)
    fail(element, fmt::format("{} bytes: expected an integer of 2 or 4", element.length));
  return static_cast<std::int64_t>(unsigned_of(bytes, element.is_big_endian));
}

std::vector<double> DicomValues::numbers(const DicomElement& element, std::int64_t limit) const {
  const std::string all = text(element, limit);
  std::vector<double> result;
  if (all.empty()) return result;
  for (std::size_t begin = 0; begin <= all.size();) {
    const std::size_t end = std::min(all.find('\\', begin), all.size());
    const std::string_view one = without_padding(std::string_view(all).substr(begin, end - begin));
    const auto value = parse_number<double>(one);
    if (!value) fail(element, fmt::format("'{}' is not a number", one.substr(0, 40)));
    // Products of a few stay finite.
    if (!(std::abs(*value) <= 1e30))
      fail(element, fmt::format("{} is beyond 1e30", one.substr(0, 40)));
    result.push_back(*value);
    begin = end + 1;
  }
  return result;
}

std::optional<double> DicomValues::number(const DicomElement& element) const {
  const auto value = exactly<1>(element);
  return value ? std::optional((*value)[0]) : std::nullopt;
}

std::optional<double> DicomValues::number_if_any(const DicomElement& element) const {
  const std::string all = text_if_any(element);
  const auto value = parse_real(without_padding(std::string_view(all).substr(0, all.find('\\'))));
  return value && std::abs(*value) <= 1e30 ? value : std::nullopt;
}

std::optional<double> DicomValues::real_if_any(const DicomElement& element) const {
  double value = 0;
  const std::string bytes = element.length == 4 || element.length == 8
                                ? source_.text(element.offset, element.length)
                                : "";
  if (bytes.size() == 8) {
    value = number_at<double>(bytes.data(), element.is_big_endian);
  } else if (bytes.size() == 4) {
    value = static_cast<double>(number_at<float>(bytes.data(), element.is_big_endian));
  } else {
    return std::nullopt;
  }
  return std::abs(value) <= 1e30 ? std::optional(value) : std::nullopt;
}

std::optional<double> DicomValues::integer_if_any(const DicomElement& element) const {
  if (element.length != 2 && element.length != 4) return std::nullopt;
  return static_cast<double>(integer(element));
}

std::optional<double> DicomValues::count_if_any(const DicomElement& element) const {
  if (element.length != 2) return number_if_any(element);
  const std::string bytes = source_.text(element.offset, 2);
  const bool is_text = bytes.find('\0') == std::string::npos;  // "36", "8 "
  return is_text ? number_if_any(element) : integer_if_any(element);
}

std::string DicomValues::text_if_any(const DicomElement& element, std::int64_t limit) const {
  return element.length > limit || element.length < 0 ? std::string() : text(element, limit);
}

std::vector<std::uint32_t> DicomValues::words_if_any(const DicomElement& element) const {
  std::vector<std::uint32_t> words;
  if (element.length > kMaxDicomValue || element.length % 4 != 0) return words;
  const std::string bytes = source_.text(element.offset, element.length);
  for (std::size_t at = 0; at + 4 <= bytes.size(); at += 4)
    words.push_back(number_at<std::uint32_t>(bytes.data() + at, element.is_big_endian));
  return words;
}

std::optional<double> dicom_time_seconds(std::string_view text) noexcept {
  text = without_padding(text.substr(0, text.find('\\')));
  const bool has_colons = text.size() > 2 && text[2] == ':';
  double seconds = 0;
  std::size_t at = 0;
  for (const double weight : {3600.0, 60.0, 1.0}) {
    const auto part = digits_at(text, at, 2);
    if (!part) return at > 0 && at >= text.size() ? std::optional(seconds) : std::nullopt;
    seconds += weight * *part;
    at += has_colons && weight > 1 ? 3 : 2;
  }
  if (at >= text.size()) return seconds;
  const std::string_view fraction = text.substr(at);
  const bool is_fraction =
      fraction[0] == '.' && fraction.find_first_not_of("0123456789", 1) == std::string_view::npos;
  if (!is_fraction) return std::nullopt;
  return seconds + parse_real(fraction).value_or(0);
}

std::optional<double> dicom_date_seconds(std::string_view text) noexcept {
  text = without_padding(text.substr(0, text.find('\\')));
  const bool has_dots = text.size() == 10 && (text[4] == '.' || text[4] == '-');
  const auto year = digits_at(text, 0, 4), month = digits_at(text, has_dots ? 5 : 4, 2),
             day = digits_at(text, has_dots ? 8 : 6, 2);
  if (!year || !month || !day) return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year{*year},
                                         std::chrono::month{static_cast<unsigned>(*month)},
                                         std::chrono::day{static_cast<unsigned>(*day)}};
  if (!date.ok()) return std::nullopt;
  return 86400.0 * static_cast<double>(std::chrono::sys_days(date).time_since_epoch().count());
}

std::optional<double> dicom_date_time_seconds(std::string_view text) noexcept {
  text = without_padding(text.substr(0, text.find_first_of("\\+-")));  // a time zone is left out
  if (text.size() < 10) return std::nullopt;
  const auto day = dicom_date_seconds(text.substr(0, 8)), time = dicom_time_seconds(text.substr(8));
  return day && time ? std::optional(*day + *time) : std::nullopt;
}

}  // namespace ovoid::io
