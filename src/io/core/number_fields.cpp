// SPDX-License-Identifier: Apache-2.0
#include "io/core/number_fields.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "io/core/text_scanner.h"

namespace ovoid::io {
namespace {

constexpr std::array<std::string_view, 8> kMissingWords{"",  "nan",  "na",   "n/a",
                                                        "-", "null", "none", "nil"};

std::string_view without_quotes(std::string_view text) {
  text = trimmed(text);
  const char quote = text.size() < 2 ? '\0' : text.front();
  if ((quote != '"' && quote != '\'') || text.back() != quote) return text;
  return trimmed(text.substr(1, text.size() - 2));
}

// From the start of a field to its end: the separator, or the end of the text.
const char* end_of_field(const char* at, const char* end, Separator separator) {
  if (at != end && *at == '"') {
    const char* const quote = std::find(at + 1, end, '"');
    if (quote != end) at = quote + 1;
  }
  if (separator == Separator::kBlanks)
    return std::find_if(at, end, [](char c) { return c == ' ' || c == '\t'; });
  return std::find(at, end, static_cast<char>(separator));
}

}  // namespace

std::optional<double> parse_field(std::string_view text) {
  constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
  std::string word = lower(without_quotes(text));
  if (std::find(kMissingWords.begin(), kMissingWords.end(), word) != kMissingWords.end())
    return kMissing;
  if (word.front() == '+') word.erase(0, 1);
  if (word.find_first_not_of("-.0123456789d+") == std::string::npos)
    std::replace(word.begin(), word.end(), 'd', 'e');  // Fortran's exponent
  double value = 0;
  const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (stop != word.data() + word.size() || error == std::errc::invalid_argument)
    return std::nullopt;
  if (error == std::errc::result_out_of_range)  // too large, or too small, which is as good as 0
    return word.find("e-") == std::string::npos ? kMissing : 0.0;
  return std::isfinite(value) ? value : kMissing;
}

std::vector<std::string_view> split_fields(std::string_view line, Separator separator) {
  std::vector<std::string_view> fields;
  const char* at = line.data();
  const char* const end = at + line.size();
  bool is_open = false;
  while (true) {
    while (at != end && (*at == ' ' || (*at == '\t' && separator != Separator::kTab))) ++at;
    if (at == end) break;
    const char* const stop = end_of_field(at, end, separator);
    fields.push_back(without_quotes({at, static_cast<std::size_t>(stop - at)}));
    is_open = stop != end && separator != Separator::kBlanks;
    at = is_open ? stop + 1 : stop;
  }
  return fields;
}

std::optional<Separator> separator_of(std::string_view line) {
  for (const Separator separator :
       {Separator::kComma, Separator::kSemicolon, Separator::kTab, Separator::kBlanks}) {
    if (separator != Separator::kBlanks &&
        line.find(static_cast<char>(separator)) == std::string_view::npos)
      continue;
    int numbers = 0;
    for (const std::string_view field : split_fields(line, separator)) {
      if (!field.empty() && parse_field(field) && ++numbers == 3) return separator;
    }
  }
  return std::nullopt;
}

std::string_view FieldReader::take() {
  const char* const stop = end_of_field(at_, end_, separator_);
  text_ = {at_, static_cast<std::size_t>(stop - at_)};
  at_ = stop;
  return text_;
}

bool FieldReader::unusual_number(double& value) {
  const std::optional<double> parsed = parse_field(take());
  if (!parsed) return false;
  value = *parsed;
  finish();
  return true;
}

bool FieldReader::skip() {
  if (!begin()) return false;
  take();
  finish();
  return true;
}

bool FieldReader::at_end() {
  begin();
  return at_ == end_;
}

}  // namespace ovoid::io
