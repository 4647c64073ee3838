// SPDX-License-Identifier: Apache-2.0
// The file is gone through twice: once up to the first lines of numbers, to see how it is laid out,
// and once to read it; once more to count the rows, if a share of them is read. A table is read in
// batches of rows, so that the arrays grow seldom and the loop over a line's fields knows where
// each of them goes.
#include "io/points/point_text.h"

#include <fmt/format.h>

#include <algorithm>
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
#include "io/points/text_rows.h"
#include "io/points/text_table.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// A table of so many lines at most, with four times as many columns, is one of quantities per line.
constexpr std::int64_t kMaxQuantityLines = 64;
constexpr std::int64_t kMinQuantityLines = 3;
constexpr std::int64_t kMinLineRatio = 4;
constexpr std::size_t kMaxPointColumns = 4096;
constexpr std::int64_t kRowsAtATime = 4096;

// A line of a table that was taken for one with decimal points.
bool has_decimal_commas(const TextTable& shape, std::string_view line) {
  if (shape.separator == Separator::kComma || line.find(',') == std::string_view::npos)
    return false;
  const auto fields = split_fields(line, shape.separator);
  for (std::size_t i = 0; i < std::min(fields.size(), shape.columns.size()); ++i) {
    if (shape.columns[i] != TextTable::Column::kText && !parse_field(fields[i]) &&
        parse_field(fields[i], DecimalMark::kComma))
      return true;
  }
  return false;
}

// How many there are; all of them say what decimal mark the numbers have, since shares of the rows
// are to agree.
std::int64_t count_rows(const ByteSource& source, TextTable& shape, ReadProgress& progress) {
  const auto stream = open_stream(source, progress);
  LineReader lines(*stream, source.name());
  TextRows rows(lines);
  std::int64_t count = 0;
  std::string_view line;
  for (bool is_one = rows.next_row_behind(shape.num_text_lines, line); is_one;
       is_one = rows.next_row(line)) {
    if (shape.mark == DecimalMark::kPoint && has_decimal_commas(shape, line))
      shape.mark = DecimalMark::kComma;
    ++count;
  }
  return count;
}

// Reads rows into a table that knows where each column goes.
class RowReader {
 public:
  RowReader(const TextTable& shape, PointTable& table)
      : shape_(shape), table_(table), slots_(shape.columns.size()) {}

  // Of all rows those that are wanted; the others' numbers are not looked at. False if one has a
  // decimal comma and the table was taken for one with points.
  bool read(LineReader& lines, const Rows& wanted) {
    TextRows rows(lines);
    std::string_view line;
    bool is_one = rows.next_row_behind(shape_.num_text_lines, line);
    for (std::int64_t row = 0; is_one && row < wanted.end(); ++row, is_one = rows.next_row(line)) {
      if (row < wanted.first) continue;
      if (num_left_ == 0) extend();
      if (!read_row(lines, line)) return false;
      --num_left_;
    }
    table_.shrink(num_left_);
    return true;
  }

 private:
  void extend() {
    const std::int64_t first = table_.num_rows();
    table_.extend(kRowsAtATime);
    num_left_ = kRowsAtATime;
    for (std::size_t i = 0; i < slots_.size(); ++i) slots_[i] = table_.slot(i, first);
  }

  bool read_row(const LineReader& lines, std::string_view line) {
    FieldReader fields(line, shape_.separator, shape_.mark);
    for (std::size_t i = 0; i < slots_.size(); ++i) {
      PointTable::Slot& slot = slots_[i];
      if (slot.first == nullptr) {
        if (!fields.skip()) fail_short(lines, i);
        continue;
      }
      if (!fields.number(*slot.first)) {
        if (shape_.mark == DecimalMark::kPoint && !fields.text().empty() &&
            !(shape_.separator == Separator::kComma && has_thousands_marks(fields.text())) &&
            parse_field(fields.text(), DecimalMark::kComma))
          return false;
        fail_number(lines, fields, i);
      }
      slot.first += slot.stride;
    }
    if (!fields.at_end()) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: has more than the {} fields of the first line of numbers",
                              lines.where(), slots_.size()));
    }
    return true;
  }

  [[noreturn]] void fail_short(const LineReader& lines, std::size_t count) const {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: has {} fields: expected {}", lines.where(), count, slots_.size()));
  }
  [[noreturn]] void fail_number(const LineReader& lines, const FieldReader& fields,
                                std::size_t column) const {
    if (fields.text().empty()) fail_short(lines, column);
    refuse_thousands(lines.where(), fields.text());
    if (shape_.mark == DecimalMark::kComma && parse_field(fields.text())) {
      throw Error(
          ErrorCode::kFileFormat,
          fmt::format("{}: field {} is '{}': other numbers have decimal commas, so that its "
                      "point may set thousands apart: expected commas or points alone",
                      lines.where(), column + 1, fields.text().substr(0, 32)));
    }
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
void append_line(const LineReader& lines, std::string_view line, const TextTable& shape,
                 SampleBuffer& out) {
  const std::int64_t count = shape.num_columns();
  FieldReader fields(line, shape.separator, shape.mark);
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

// The lines of one array each, side by side; zeros for a component that has none.
Bytes interleave_lines(std::vector<SampleBuffer>& lines, const PointLayout& layout, int array,
                       std::int64_t count) {
  const int num_components = layout.arrays[static_cast<std::size_t>(array)].num_components;
  const auto width = static_cast<std::size_t>(num_components);
  SampleBuffer result;
  const auto num_bytes = count * num_components * static_cast<std::int64_t>(sizeof(double));
  auto* const to = reinterpret_cast<double*>(result.extend(num_bytes, num_bytes).data());
  std::fill(to, to + static_cast<std::size_t>(count) * width, 0.0);
  for (std::size_t c = 0; c < lines.size(); ++c) {
    const PointLayout::Target& target = layout.targets[c];
    if (target.array != array) continue;
    const auto* const from = reinterpret_cast<const double*>(lines[c].bytes().data());
    const auto component = static_cast<std::size_t>(target.component);
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
      to[i * width + component] = from[i];
    lines[c].release();
  }
  if (array == 0) PointTable::place(layout, {to, static_cast<std::size_t>(count) * width});
  return result.release();
}

void read_quantities(const ByteSource& source, const TextTable& shape, LineReader& lines,
                     Dataset& dataset) {
  const std::int64_t count = shape.num_columns();
  const std::vector<std::string> names =
      names_in(source.name(), shape, shape.num_lines, dataset.notes);
  std::vector<PointColumn> columns;
  columns.reserve(names.size());
  for (const std::string& name : names) columns.push_back({name});
  dataset.notes.push_back(
      fmt::format("{}: {} lines of {} numbers each: taken as one quantity per line, not one point",
                  source.name(), shape.num_lines, count));
  const PointLayout layout = lay_out_points(source.name(), columns, dataset.notes);
  std::vector<SampleBuffer> values(columns.size());
  TextRows rows(lines);
  std::string_view line;
  std::size_t next = 0;
  for (bool is_one = rows.next_row_behind(shape.num_text_lines, line);
       is_one && next < values.size(); is_one = rows.next_row(line))
    append_line(lines, line, shape, values[next++]);
  if (next < values.size()) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: had {} lines of numbers when it was opened, and has {}",
                            source.name(), values.size(), next));
  }
  dataset.kind = DatasetKind::kParticles;
  for (std::size_t i = 0; i < layout.arrays.size(); ++i) {
    const PointLayout::Array& array = layout.arrays[i];
    DataArray made{array.name,
                   ScalarType::kFloat64,
                   array.num_components,
                   count,
                   array.unit,
                   false,
                   interleave_lines(values, layout, static_cast<int>(i), count)};
    if (i == 0)
      dataset.positions = std::move(made);
    else
      dataset.arrays.push_back(std::move(made));
  }
}

PointLayout lay_out_table(const std::string& where, const TextTable& shape,
                          std::vector<std::string>& notes) {
  if (shape.columns.size() > kMaxPointColumns) {
    throw Error(ErrorCode::kUnsupported, fmt::format("{}: {} columns: expected at most {}", where,
                                                     shape.columns.size(), kMaxPointColumns));
  }
  const std::vector<std::string> names = names_in(where, shape, shape.num_columns(), notes);
  std::vector<PointColumn> columns;
  for (std::size_t i = 0; i < names.size(); ++i) {
    columns.push_back({names[i], shape.columns[i] != TextTable::Column::kText,
                       shape.columns[i] == TextTable::Column::kEmpty});
  }
  return lay_out_points(where, columns, notes);
}

// What is read of a table: all of it, or a share of rows that were counted.
struct WantedRows {
  std::optional<RowShare> share;
  std::optional<std::int64_t> num_rows;
};

// False, and nothing is in the dataset, if the table's numbers have decimal commas after all.
bool read_rows(const ByteSource& source, const TextTable& shape, ReadProgress& progress,
               const WantedRows& asked, Dataset& dataset) {
  std::vector<std::string> notes;
  PointTable table(lay_out_table(source.name(), shape, notes));
  const Rows wanted = asked.num_rows ? rows_of_share(asked.share, *asked.num_rows)
                                     : Rows{0, std::numeric_limits<std::int64_t>::max()};
  const auto stream = open_stream(source, progress);
  LineReader lines(*stream, source.name());
  if (!RowReader(shape, table).read(lines, wanted)) return false;
  if (asked.num_rows && table.num_rows() < wanted.count) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: had {} lines of numbers when it was opened, and has fewer",
                            source.name(), *asked.num_rows));
  }
  if (shape.mark == DecimalMark::kComma)
    notes.push_back(fmt::format("{}: commas are taken for decimal ones", source.name()));
  dataset.notes = std::move(notes);
  table.release(dataset);
  if (asked.num_rows) set_share(dataset, asked.share, *asked.num_rows);
  return true;
}

}  // namespace

Dataset read_point_text(const ByteSource& source, const ReadOptions& options) {
  TextTable shape = look_at_table(source);
  Dataset dataset;
  dataset.source = source.name();
  dataset.format = plain_ending_of(source.name()) == ".csv" ? "CSV" : "text";
  const bool is_by_line = shape.num_lines >= kMinQuantityLines &&
                          shape.num_lines <= kMaxQuantityLines &&
                          shape.num_columns() >= kMinLineRatio * shape.num_lines;
  // Which rows are a share's is known when all are counted.
  const bool is_counted = options.share && !is_by_line;
  ReadProgress progress(options, is_counted ? 2 * source.size() : source.size());
  if (is_by_line) {
    const auto stream = open_stream(source, progress);
    LineReader lines(*stream, source.name());
    read_quantities(source, shape, lines, dataset);
    return dataset;
  }
  WantedRows asked{options.share, {}};
  if (is_counted) asked.num_rows = count_rows(source, shape, progress);
  if (!read_rows(source, shape, progress, asked, dataset)) {
    shape.mark = DecimalMark::kComma;
    read_rows(source, shape, progress, asked, dataset);
  }
  return dataset;
}

}  // namespace ovoid::io
