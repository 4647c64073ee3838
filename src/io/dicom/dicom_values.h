// SPDX-License-Identifier: Apache-2.0
// What the values of data elements say, as text and as numbers.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/core/byte_source.h"
#include "io/dicom/dicom_elements.h"

namespace ovoid::io {

// Longer values of the elements that are read are not what they should be.
inline constexpr std::int64_t kMaxDicomValue = 1024;

// Reads values of a file's elements. All but the ..._if_any throw Error(kFileFormat) naming file
// and element.
class DicomValues {
 public:
  explicit DicomValues(const ByteSource& source) : source_(source) {}

  [[noreturn]] void fail(const DicomElement& element, const std::string& what) const;

  // Without the padding around it.
  std::string text(const DicomElement& element, std::int64_t limit = kMaxDicomValue) const;
  // An unsigned short, or whatever else of up to four bytes a writer took for it.
  std::int64_t integer(const DicomElement& element) const;
  // Numbers between backslashes. Empty if the value is.
  std::vector<double> numbers(const DicomElement& element,
                              std::int64_t limit = kMaxDicomValue) const;
  std::optional<double> number(const DicomElement& element) const;

  template <std::size_t count>
  std::optional<std::array<double, count>> exactly(const DicomElement& element) const {
    const std::vector<double> values = numbers(element);
    if (values.empty()) return std::nullopt;
    if (values.size() != count) fail_count(element, values.size(), count);
    std::array<double, count> result;
    std::copy(values.begin(), values.end(), result.begin());
    return result;
  }

  // Of elements that only sort or describe odd values are passed over: the first number of a text,
  // a binary float or double, a binary integer of two or four bytes, a text.
  std::optional<double> number_if_any(const DicomElement& element) const;
  std::optional<double> real_if_any(const DicomElement& element) const;
  std::optional<double> integer_if_any(const DicomElement& element) const;
  // A short integer, or a text with a number where a program has changed the file.
  std::optional<double> count_if_any(const DicomElement& element) const;
  std::string text_if_any(const DicomElement& element, std::int64_t limit = kMaxDicomValue) const;
  // Binary numbers of four bytes each.
  std::vector<std::uint32_t> words_if_any(const DicomElement& element) const;

 private:
  [[noreturn]] void fail_count(const DicomElement& element, std::size_t count,
                               std::size_t expected) const;

  const ByteSource& source_;
};

// Seconds of a time of day (HHMMSS.FFFFFF; colons between are an older way), of a date (YYYYMMDD)
// since 1970, and of both in one; nothing for what is none.
std::optional<double> dicom_time_seconds(std::string_view text) noexcept;
std::optional<double> dicom_date_seconds(std::string_view text) noexcept;
std::optional<double> dicom_date_time_seconds(std::string_view text) noexcept;

}  // namespace ovoid::io
