// SPDX-License-Identifier: Apache-2.0
// The lines of a table as text, as spreadsheets count them: a field in quotes may hold line breaks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "io/core/byte_stream.h"

namespace ovoid::io {

// What stands in a comment, behind its marks; nothing if the line is none. Marks are #, %, ! and //
// at its start. "#N/A" and its like are no marks but missing values.
struct TextComment {
  bool is_comment = false;
  std::string_view text;
};
TextComment comment_in(std::string_view line);

// Walks the lines that are not blank, without a byte order mark.
class TextRows {
 public:
  // A field in quotes is not longer: a quote that nobody closes is not to swallow the table.
  static constexpr std::size_t kLongestQuote = std::size_t{1} << 20;

  explicit TextRows(LineReader& lines) : lines_(lines) {}

  // The next line, comments among them; false at the end. Lines that quotes hold together are
  // joined by blanks. Valid until the next call. Throws Error(kFileFormat) for a quote that is not
  // closed.
  bool next(std::string_view& line);
  // The next that is no comment.
  bool next_row(std::string_view& line);
  // The same, and passes `count` rows before.
  bool next_row_behind(std::int64_t count, std::string_view& line);

 private:
  LineReader& lines_;
  std::string joined_;
};

}  // namespace ovoid::io
