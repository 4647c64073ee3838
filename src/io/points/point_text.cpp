// SPDX-License-Identifier: Apache-2.0
// The file is gone through twice: once up to the first lines of numbers, to see how it is laid out,
// and once to read it; once more to count the rows, if a share of them is read. A table is read in
// batches of rows, so that the arrays grow seldom and the loop over a line's fields knows where
// each of them goes.
#include "io/points/point_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/core/byte_stream.h"
#include "io/core/number_fields.h"
#include "io/core/row_share.h"
#include "io/core/samples.h"
#include "io/core/signatures.h"
#include "io/core/text_scanner.h"
#include "io/points/point_columns.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// A table of so many lines at most, with four times as many columns, is one of quantities per line.
constexpr std::int64_t kMaxQuantityLines = 64;
constexpr std::int64_t kMinQuantityLines = 3;
constexpr std::int64_t kMinLineRatio = 4;
constexpr std::size_t kMaxPointColumns = 4096;
constexpr std::int64_t kRowsAtATime = 4096;

// What the first lines show.
struct TextTable {
  std::string names;     // the line of names, or the comment that may be one
  bool is_sure = false;  // it is no comment
  std::int64_t num_columns = 0;
  std::int64_t num_lines = 0;  // of numbers, counted up to one more than kMaxQuantityLines
  Separator separator = Separator::kBlanks;
  std::vector<bool> is_number;  // of each column, by the first line of numbers
};

std::string_view without_mark(std::string_view line) {
  if (line.starts_with("\xef\xbb\xbf")) line.remove_prefix(3);  // a byte order mark
  return line;
}

bool is_left_out(std::string_view line) {
  const auto first = line.find_first_not_of(" \t");
  return first == std::string_view::npos || line[first] == '#';
}

void look_at_first_line(const LineReader& lines, std::string_view line, TextTable& table) {
  if (const auto separator = separator_of(line)) {
    table.separator = *separator;
    const auto fields = split_fields(line, *separator);
    for (const std::string_view field : fields)
      table.is_number.push_back(parse_field(field).has_value());
    // A last field may be empty in this line, and not in others.
    const std::size_t num_names =
        table.is_sure ? split_fields(table.names, *separator).size() : fields.size();
    if (num_names == fields.size() + 1 && line.ends_with(static_cast<char>(*separator)))
      table.is_number.push_back(true);
    table.num_columns = static_cast<std::int64_t>(table.is_number.size());
    table.num_lines = 1;
    return;
  }
  if (table.is_sure) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: '{}': expected at least three numbers for x, y, z", lines.where(),
                            line.substr(0, 40)));
  }
  table.names = line;
  table.is_sure = true;
}

TextTable look_at_table(const ByteSource& source) {
  const ReadOptions options;
  ReadProgress progress(options, 0);
  const auto stream = open_stream(source, progress);
  LineReader lines(*stream, source.name());
  TextTable table;
  std::string_view line;
  while (table.num_lines <= kMaxQuantityLines && lines.next(line)) {
    if (lines.number() == 1) line = without_mark(line);
    if (is_left_out(line)) {
      // The last comment before the numbers may name the columns, as numpy.savetxt writes it.
      const auto mark = line.find('#');
      if (mark != std::string_view::npos && table.num_lines == 0 && !table.is_sure)
        table.names = line.substr(line.find_first_not_of("# \t") == std::string_view::npos
                                      ? line.size()
                                      : line.find_first_not_of("# \t"));
    } else if (table.num_lines > 0) {
      ++table.num_lines;
    } else {
      look_at_first_line(lines, line, table);
    }
  }
  if (table.num_lines == 0) {
    throw Error(
        ErrorCode::kFileFormat,
        fmt::format("{}: holds no line of numbers: expected rows of x, y, z", source.name()));
  }
  return table;
}

// As many names as there are columns, or none.
std::vector<std::string> names_for(const std::string& where, const TextTable& table,
                                   std::int64_t count, std::vector<std::string>& notes) {
  std::vector<std::string> names;
  for (const Separator separator : {table.separator, Separator::kComma, Separator::kBlanks}) {
    const auto fields = split_fields(table.names, separator);
    if (static_cast<std::int64_t>(fields.size()) != count) continue;
    names.assign(fields.begin(), fields.end());
    const bool has_number = std::any_of(fields.begin(), fields.end(), [](std::string_view field) {
      return !field.empty() && parse_field(field).has_value();
    });
    if (!table.is_sure && has_number) names.clear();  // a comment about something else
    break;
  }
  if (names.empty() && table.is_sure) {
    notes.push_back(fmt::format("{}: the line of names '{}' does not have {} of them: ignored",
                                where, table.names.substr(0, 60), count));
  }
  names.resize(static_cast<std::size_t>(count));
  return names;
}

// Walks the lines that are rows: all but comments and the names.
class RowLines {
 public:
  RowLines(const TextTable& shape, LineReader& lines) : lines_(lines), has_names_(shape.is_sure) {}

  bool next(std::string_view& line) {
    while (lines_.next(line)) {
      if (lines_.number() == 1) line = without_mark(line);
      if (is_left_out(line)) continue;
      if (!std::exchange(has_names_, false)) return true;
    }
    return false;
  }

 private:
  LineReader& lines_;
  bool has_names_;
};

std::int64_t count_rows(const ByteSource& source, const TextTable& shape, ReadProgress& progress) {
  const auto stream = open_stream(source, progress);
  LineReader lines(*stream, source.name());
  RowLines rows(shape, lines);
  std::int64_t count = 0;
  for (std::string_view line; rows.next(line);) ++count;
  return count;
}

// Reads rows into a table that knows where each column goes.
class RowReader {
 public:
  RowReader(const TextTable& shape, PointTable& table)
      : shape_(shape), table_(table), slots_(shape.is_number.size()) {}

  // Of all rows those that are wanted; the others' numbers are not looked at.
  void read(LineReader& lines, const Rows& wanted) {
    RowLines rows(shape_, lines);
    std::string_view line;
    for (std::int64_t row = 0; row < wanted.end() && rows.next(line); ++row) {
      if (row < wanted.first) continue;
      if (num_left_ == 0) extend();
      read_row(lines, line);
      --num_left_;
    }
    table_.shrink(num_left_);
  }

 private:
  void extend() {
    const std::int64_t first = table_.num_rows();
    table_.extend(kRowsAtATime);
    num_left_ = kRowsAtATime;
    for (std::size_t i = 0; i < slots_.size(); ++i) slots_[i] = table_.slot(i, first);
  }

  void read_row(const LineReader& lines, std::string_view line) {
    FieldReader fields(line, shape_.separator);
    for (std::size_t i = 0; i < slots_.size(); ++i) {
      PointTable::Slot& slot = slots_[i];
      if (slot.first == nullptr) {
        if (!fields.skip()) fail_short(lines, i);
        continue;
      }
      if (!fields.number(*slot.first)) fail_number(lines, fields, i);
      slot.first += slot.stride;
    }
    if (!fields.at_end()) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: has more than the {} fields of the first line of numbers",
                              lines.where(), slots_.size()));
    }
  }

  [[noreturn]] void fail_short(const LineReader& lines, std::size_t count) const {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: has {} fields: expected {}", lines.where(), count, slots_.size()));
  }
  [[noreturn]] void fail_number(const LineReader& lines, const FieldReader& fields,
                                std::size_t column) const {
    if (fields.text().empty()) fail_short(lines, column);
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: field {} is '{}': expected a number", lines.where(), column + 1,
                            fields.text().substr(0, 32)));
  }

  const TextTable& shape_;
  PointTable& table_;
  std::vector<PointTable::Slot> slots_;
  std::int64_t num_left_ = 0;  // rows that there is room for
};

// One array of numbers per line.
void append_line(const LineReader& lines, std::string_view line, Separator separator,
                 std::int64_t count, SampleBuffer& out) {
  FieldReader fields(line, separator);
  const auto num_bytes = count * static_cast<std::int64_t>(sizeof(double));
  auto* const to = reinterpret_cast<double*>(out.extend(num_bytes, num_bytes).data());
  for (std::int64_t i = 0; i < count; ++i) {
    if (fields.number(to[i])) continue;
    throw Error(ErrorCode::kFileFormat,
                fields.text().empty()
                    ? fmt::format("{}: has {} numbers: expected {}", lines.where(), i, count)
                    : fmt::format("{}: number {} is '{}': expected a number", lines.where(), i + 1,
                                  fields.text().substr(0, 32)));
  }
  if (!fields.at_end()) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: has more than the {} numbers of the first", lines.where(), count));
  }
}

// The lines of one array each, side by side.
Bytes interleave_lines(std::vector<SampleBuffer>& lines, const std::vector<std::size_t>& which,
                       std::int64_t count) {
  if (which.size() == 1) return lines[which[0]].release();
  SampleBuffer result;
  const auto num_bytes =
      count * static_cast<std::int64_t>(which.size()) * static_cast<std::int64_t>(sizeof(double));
  auto* const to = reinterpret_cast<double*>(result.extend(num_bytes, num_bytes).data());
  for (std::size_t c = 0; c < which.size(); ++c) {
    const auto* const from = reinterpret_cast<const double*>(lines[which[c]].bytes().data());
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
      to[i * which.size() + c] = from[i];
    lines[which[c]].release();
  }
  return result.release();
}

void read_quantities(const ByteSource& source, const TextTable& shape, LineReader& lines,
                     Dataset& dataset) {
  const std::int64_t count = shape.num_columns;
  const std::vector<std::string> names =
      names_for(source.name(), shape, shape.num_lines, dataset.notes);
  std::vector<PointColumn> columns;
  columns.reserve(names.size());
  for (const std::string& name : names) columns.push_back({name});
  dataset.notes.push_back(
      fmt::format("{}: {} lines of {} numbers each: taken as one quantity per line, not one point",
                  source.name(), shape.num_lines, count));
  const PointLayout layout = lay_out_points(source.name(), columns, dataset.notes);
  std::vector<SampleBuffer> values(columns.size());
  std::string_view line;
  std::size_t next = 0;
  bool has_names = shape.is_sure;
  while (lines.next(line)) {
    if (lines.number() == 1) line = without_mark(line);
    if (is_left_out(line)) continue;
    if (!has_names && next < values.size())
      append_line(lines, line, shape.separator, count, values[next++]);
    has_names = false;
  }
  if (next < values.size()) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: had {} lines of numbers when it was opened, and has {}",
                            source.name(), values.size(), next));
  }
  dataset.kind = DatasetKind::kParticles;
  for (std::size_t i = 0; i < layout.arrays.size(); ++i) {
    const PointLayout::Array& array = layout.arrays[i];
    std::vector<std::size_t> which(static_cast<std::size_t>(array.num_components));
    for (std::size_t c = 0; c < columns.size(); ++c) {
      if (layout.targets[c].array == static_cast<int>(i))
        which[static_cast<std::size_t>(layout.targets[c].component)] = c;
    }
    DataArray made{array.name,
                   ScalarType::kFloat64,
                   array.num_components,
                   count,
                   array.unit,
                   false,
                   interleave_lines(values, which, count)};
    if (i == 0)
      dataset.positions = std::move(made);
    else
      dataset.arrays.push_back(std::move(made));
  }
}

void read_rows(const ByteSource& source, const TextTable& shape, LineReader& lines,
               const std::optional<std::int64_t>& num_rows, const std::optional<RowShare>& share,
               Dataset& dataset) {
  if (shape.is_number.size() > kMaxPointColumns) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: {} columns: expected at most {}", source.name(),
                            shape.is_number.size(), kMaxPointColumns));
  }
  const std::vector<std::string> names =
      names_for(source.name(), shape, shape.num_columns, dataset.notes);
  std::vector<PointColumn> columns;
  for (std::size_t i = 0; i < names.size(); ++i) columns.push_back({names[i], shape.is_number[i]});
  PointTable table(lay_out_points(source.name(), columns, dataset.notes));
  const Rows wanted = num_rows ? rows_of_share(share, *num_rows)
                               : Rows{0, std::numeric_limits<std::int64_t>::max()};
  RowReader(shape, table).read(lines, wanted);
  if (num_rows && table.num_rows() < wanted.count) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: had {} lines of numbers when it was opened, and has fewer",
                            source.name(), *num_rows));
  }
  table.release(dataset);
  if (num_rows) set_share(dataset, share, *num_rows);
}

}  // namespace

Dataset read_point_text(const ByteSource& source, const ReadOptions& options) {
  const TextTable shape = look_at_table(source);
  Dataset dataset;
  dataset.source = source.name();
  dataset.format = plain_ending_of(source.name()) == ".csv" ? "CSV" : "text";
  const bool is_by_line = shape.num_lines >= kMinQuantityLines &&
                          shape.num_lines <= kMaxQuantityLines &&
                          shape.num_columns >= kMinLineRatio * shape.num_lines;
  // Which rows are a share's is known when all are counted.
  const bool is_counted = options.share && !is_by_line;
  ReadProgress progress(options, is_counted ? 2 * source.size() : source.size());
  std::optional<std::int64_t> num_rows;
  if (is_counted) num_rows = count_rows(source, shape, progress);
  const auto stream = open_stream(source, progress);
  LineReader lines(*stream, source.name());
  if (is_by_line)
    read_quantities(source, shape, lines, dataset);
  else
    read_rows(source, shape, lines, num_rows, options.share, dataset);
  return dataset;
}

}  // namespace ovoid::io
