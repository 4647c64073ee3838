// SPDX-License-Identifier: Apache-2.0
#include "io/points/text_rows.h"

#include <fmt/format.h>

#include <algorithm>

#include "io/core/number_fields.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

// Walks a line by its quotes, which begin where a field does.
class Quotes {
 public:
  void pass(std::string_view line) {
    bool starts_field = !is_open_;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const char c = line[i];
      if (is_open_) {
        if (c != '"') continue;
        if (i + 1 < line.size() && line[i + 1] == '"')
          ++i;  // one quote that is part of the field
        else
          is_open_ = false;
      } else if (c == ',' || c == ';' || c == '\t' || c == '|') {
        starts_field = true;
      } else if (c == '"' && starts_field) {
        is_open_ = true;
        starts_field = false;
      } else if (c != ' ') {
        starts_field = false;
      }
    }
  }
  bool is_open() const noexcept { return is_open_; }

 private:
  bool is_open_ = false;
};

}  // namespace

TextComment comment_in(std::string_view line) {
  const auto first = line.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  line.remove_prefix(first);
  const bool is_slashes = line.starts_with("//");
  if (!is_slashes && line[0] != '#' && line[0] != '%' && line[0] != '!') return {};
  if (line[0] == '#' && line.size() > 1 &&
      parse_field(line.substr(0, line.find_first_of(" ,;\t|"))))
    return {};
  const auto text = line.find_first_not_of(is_slashes ? "/ \t" : "#%! \t");
  return {true, text == std::string_view::npos ? std::string_view() : line.substr(text)};
}

bool TextRows::next(std::string_view& line) {
  do {
    if (!lines_.next(line)) return false;
    if (lines_.number() == 1 && line.starts_with(kByteOrderMark))
      line.remove_prefix(kByteOrderMark.size());
  } while (line.find_first_not_of(" \t") == std::string_view::npos);
  if (line.find('"') == std::string_view::npos || comment_in(line).is_comment) return true;
  Quotes quotes;
  quotes.pass(line);
  if (!quotes.is_open()) return true;
  const std::string begin = lines_.where();
  joined_ = line;
  while (quotes.is_open()) {
    if (joined_.size() > kLongestQuote || !lines_.next(line)) {
      throw Error(ErrorCode::kFileFormat, fmt::format("{}: a field's quote is not closed", begin));
    }
    quotes.pass(line);
    joined_ += ' ';
    joined_ += line;
  }
  line = joined_;
  return true;
}

bool TextRows::next_row(std::string_view& line) {
  do {
    if (!next(line)) return false;
  } while (comment_in(line).is_comment);
  return true;
}

bool TextRows::next_row_behind(std::int64_t count, std::string_view& line) {
  for (std::int64_t i = 0; i <= count; ++i)
    if (!next_row(line)) return false;
  return true;
}

}  // namespace ovoid::io
