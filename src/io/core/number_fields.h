// SPDX-License-Identifier: Apache-2.0
// Lines of numbers: fields between commas, semicolons, tabs, bars or blanks.
#pragma once

#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace ovoid::io {

// What stands between two fields. kBlanks: any number of blanks and tabs.
enum class Separator : char {
  kComma = ',',
  kSemicolon = ';',
  kTab = '\t',
  kBar = '|',
  kBlanks = ' '
};

// What stands before a number's decimals.
enum class DecimalMark : char { kPoint = '.', kComma = ',' };

// A double as text in any of the ways that programs write it: a plus sign, Fortran's exponent D or
// none of its letters ("1.5-103"), quotes, blanks around it; NaN for the words and the emptiness
// that stand for a missing one (spreadsheets' errors among them), for infinity, and for what is
// beyond a double's range. Nothing if it is no number: with decimal commas, one with a point is
// none.
std::optional<double> parse_field(std::string_view text, DecimalMark mark = DecimalMark::kPoint);

// Does the text look like a number whose thousands are set apart: 1,234 or 1.234.567,8?
bool has_thousands_marks(std::string_view text);

// The fields of a line, blanks and quotes around them taken off. A separator within quotes is none,
// nor is one behind the last field. A quote within quotes stays doubled.
std::vector<std::string_view> split_fields(std::string_view line, Separator separator);

// Walks the fields of a line of numbers.
class FieldReader {
 public:
  FieldReader(std::string_view line, Separator separator, DecimalMark mark = DecimalMark::kPoint)
      : at_(line.data()), end_(line.data() + line.size()), separator_(separator), mark_(mark) {}

  // Passes the next field; false if there is none, or it is no number: then text() is what it is.
  bool number(double& value) {
    if (!begin()) {
      text_ = {};
      return false;
    }
    if (mark_ == DecimalMark::kComma) return unusual_number(value);
    const auto [stop, error] = std::from_chars(at_, end_, value);
    // The common case: digits, and the separator behind them.
    if (error == std::errc{} && is_finite(value) && (stop == end_ || is_end(*stop))) {
      at_ = stop;
      finish();
      return true;
    }
    return unusual_number(value);
  }

  // Passes the next field; false if there is none.
  bool skip();
  // Are there fields left? A separator that ends the line begins no field.
  bool at_end();
  // Of the field that number() did not like.
  std::string_view text() const noexcept { return text_; }

 private:
  static bool is_blank_char(char c) noexcept { return c == ' ' || c == '\t'; }
  static bool is_finite(double value) noexcept { return value - value == 0.0; }
  bool is_end(char c) const noexcept {
    return c == static_cast<char>(separator_) || (separator_ == Separator::kBlanks && c == '\t');
  }
  // To the field's first character; false at the end of the line.
  bool begin() noexcept {
    if (separator_ == Separator::kTab) {
      while (at_ != end_ && *at_ == ' ') ++at_;
    } else {
      while (at_ != end_ && is_blank_char(*at_)) ++at_;
    }
    return at_ != end_ || is_open_;
  }
  // Past the separator behind a field.
  void finish() noexcept {
    is_open_ = false;
    if (separator_ == Separator::kBlanks || at_ == end_) return;
    ++at_;
    is_open_ = true;
  }
  std::string_view take();
  bool unusual_number(double& value);

  const char* at_;
  const char* end_;
  Separator separator_;
  DecimalMark mark_;
  bool is_open_ = false;  // a separator was passed, so another field follows, if only an empty one
  std::string_view text_;
};

}  // namespace ovoid::io
