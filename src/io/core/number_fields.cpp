// SPDX-License-Identifier: Apache-2.0
#include "io/core/number_fields.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "io/core/text_scanner.h"

namespace ovoid::io {
namespace {

// In small letters. Those with '#' are spreadsheets', or Microsoft's C library's.
constexpr std::array kMissingWords = std::to_array<std::string_view>(
    {"",        "nan",    "na",        "n/a",      "-",       "--",       "---",    "null",
     "none",    "nil",    "?",         ".",        "\\n",     "<na>",     "-nan",   "nan(ind)",
     "#n/a",    "#na",    "-nan(ind)", "#n/a n/a", "#null!",  "#div/0!",  "#num!",  "#ref!",
     "#value!", "#name?", "1.#ind",    "-1.#ind",  "1.#qnan", "-1.#qnan", "1.#inf", "-1.#inf"});

std::string_view without_quotes(std::string_view text) {
  text = trimmed(text);
  const char quote = text.size() < 2 ? '\0' : text.front();
  if ((quote != '"' && quote != '\'') || text.back() != quote) return text;
  return trimmed(text.substr(1, text.size() - 2));
}

// Fortran leaves the letter out where an exponent has three digits: 1.5-103.
void add_exponent_letter(std::string& word) {
  if (word.size() < 6) return;
  const std::size_t sign = word.size() - 4;
  if ((word[sign] != '-' && word[sign] != '+') ||
      word.find_first_not_of("0123456789", sign + 1) != std::string::npos ||
      word.find_first_not_of("-.0123456789") < sign || word.find('.') >= sign)
    return;
  word.insert(sign, 1, 'e');
}

// From the start of a field to its end: the separator, or the end of the text.
const char* end_of_field(const char* at, const char* end, Separator separator) {
  if (at != end && *at == '"') {
    const char* quote = std::find(at + 1, end, '"');
    while (end - quote > 1 && quote[1] == '"') quote = std::find(quote + 2, end, '"');
    if (quote != end) at = quote + 1;
  }
  if (separator == Separator::kBlanks)
    return std::find_if(at, end, [](char c) { return c == ' ' || c == '\t'; });
  return std::find(at, end, static_cast<char>(separator));
}

}  // namespace

std::optional<double> parse_field(std::string_view text, DecimalMark mark) {
  constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
  std::string word = lower(without_quotes(text));
  if (std::find(kMissingWords.begin(), kMissingWords.end(), word) != kMissingWords.end())
    return kMissing;
  if (mark == DecimalMark::kComma) {
    if (word.find('.') != std::string::npos) return std::nullopt;
    if (const auto comma = word.find(','); comma != std::string::npos) word[comma] = '.';
  }
  if (word.front() == '+') word.erase(0, 1);
  if (word.find_first_not_of("-.0123456789d+") == std::string::npos)
    std::replace(word.begin(), word.end(), 'd', 'e');  // Fortran's exponent
  add_exponent_letter(word);
  double value = 0;
  const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (stop != word.data() + word.size() || error == std::errc::invalid_argument)
    return std::nullopt;
  if (error == std::errc::result_out_of_range)  // too large, or too small, which is as good as 0
    return word.find("e-") == std::string::npos ? kMissing : 0.0;
  return std::isfinite(value) ? value : kMissing;
}

bool has_thousands_marks(std::string_view text) {
  text = without_quotes(text);
  if (!text.empty() && (text.front() == '-' || text.front() == '+')) text.remove_prefix(1);
  const auto digits = [&](std::size_t at) {
    std::size_t count = 0;
    while (at + count < text.size() && text[at + count] >= '0' && text[at + count] <= '9') ++count;
    return count;
  };
  std::size_t at = digits(0);
  if (at < 1 || at > 3 || at == text.size()) return false;
  const char mark = text[at];
  if (mark != ',' && mark != '.' && mark != '\'' && mark != ' ') return false;
  int groups = 0;
  for (; at < text.size() && text[at] == mark; ++groups) {
    if (digits(at + 1) != 3) return false;
    at += 4;
  }
  if (at == text.size()) return mark != '.' || groups > 1;  // 1.234 is a number like others
  if (text[at] != '.' && text[at] != ',') return false;
  return at + 1 + digits(at + 1) == text.size();
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

std::string_view FieldReader::take() {
  const char* const stop = end_of_field(at_, end_, separator_);
  text_ = {at_, static_cast<std::size_t>(stop - at_)};
  at_ = stop;
  return text_;
}

bool FieldReader::unusual_number(double& value) {
  const std::optional<double> parsed = parse_field(take(), mark_);
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
