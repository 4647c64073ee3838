// SPDX-License-Identifier: Apache-2.0
// How a table as text is laid out, by its first lines: what separates its fields, what stands
// before decimals, which lines are a heading and which of them names the columns.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/core/byte_source.h"
#include "io/core/number_fields.h"

namespace ovoid::io {

struct TextTable {
  // So many lines of numbers are looked at.
  static constexpr std::int64_t kMostLines = 65;

  struct HeadingLine {
    std::string text;  // a comment's without its marks
    bool is_comment = false;
  };
  enum class Column : std::uint8_t { kEmpty, kNumbers, kText };

  std::vector<HeadingLine> heading;  // the last ones before the numbers
  std::int64_t num_text_lines = 0;   // before the numbers that are no comments
  std::int64_t num_lines = 0;        // of numbers, up to kMostLines
  Separator separator = Separator::kBlanks;
  DecimalMark mark = DecimalMark::kPoint;
  std::vector<Column> columns;  // by the lines that were looked at

  std::int64_t num_columns() const noexcept { return static_cast<std::int64_t>(columns.size()); }
};

// Throws Error(kFileFormat) for what has no line of three numbers, kUnsupported for Tecplot's
// files.
TextTable look_at_table(const ByteSource& source);

// Throws Error(kFileFormat) if the text is a number with marks between its thousands. `where`: file
// and line.
void refuse_thousands(const std::string& where, std::string_view text);

// The names of `count` columns, or lines, as the heading has them, with the units of a line of
// their own behind them ("T [K]"); empty ones where it names none. Notes what of the heading is
// passed over.
std::vector<std::string> names_in(const std::string& where, const TextTable& table,
                                  std::int64_t count, std::vector<std::string>& notes);

}  // namespace ovoid::io
