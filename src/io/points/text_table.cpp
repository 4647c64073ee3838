// SPDX-License-Identifier: Apache-2.0
#include "io/points/text_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "io/core/byte_stream.h"
#include "io/core/text_scanner.h"
#include "io/points/point_columns.h"
#include "io/points/text_rows.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kMostTextLines = 256;  // a heading is shorter; other texts are no tables
constexpr std::size_t kMostHeadingLines = 64;
constexpr std::size_t kLongestHeadingLine = std::size_t{1} << 20;
constexpr int kLeastNumbers = 3;

constexpr std::array kSeparators{Separator::kComma, Separator::kSemicolon, Separator::kTab,
                                 Separator::kBar, Separator::kBlanks};

// A line's fields under one separator.
struct FieldLayout {
  Separator separator = Separator::kBlanks;
  DecimalMark mark = DecimalMark::kPoint;
  std::vector<std::string_view> fields;
  int num_numbers = 0;
  bool has_value = false;  // one of the numbers is not missing
};

FieldLayout lay_out(std::string_view line, Separator separator) {
  FieldLayout best;
  const auto fields = split_fields(line, separator);
  for (const DecimalMark mark : {DecimalMark::kPoint, DecimalMark::kComma}) {
    FieldLayout layout{separator, mark, fields, 0, false};
    for (const std::string_view field : fields) {
      if (field.empty()) continue;
      // Those with marks between thousands are refused when the table is known to be one.
      const auto number =
          has_thousands_marks(field) ? std::optional(1.0) : parse_field(field, mark);
      if (!number) continue;
      ++layout.num_numbers;
      layout.has_value = layout.has_value || std::isfinite(*number);
    }
    if (layout.num_numbers > best.num_numbers) best = std::move(layout);
  }
  return best;
}

// Words, those in brackets or behind '@' joined to the name before: "T (K) @ t=0".
std::vector<std::string> merged_words(std::string_view line) {
  std::vector<std::string> names;
  int depth = 0;
  bool is_behind_at = false;
  std::string_view before;
  for (const std::string_view word : words(line)) {
    const bool is_joined =
        !names.empty() &&
        (depth > 0 || word[0] == '(' || word[0] == '[' || word == "@" ||
         (is_behind_at && (before == "@" || before.ends_with(':') || before.ends_with(',') ||
                           word.find('=') != std::string_view::npos)));
    if (is_joined)
      names.back().append(" ").append(word);
    else
      names.emplace_back(word);
    is_behind_at = word == "@" || (is_joined && is_behind_at);
    depth += static_cast<int>(
        std::count_if(word.begin(), word.end(), [](char c) { return c == '(' || c == '['; }));
    depth -= static_cast<int>(
        std::count_if(word.begin(), word.end(), [](char c) { return c == ')' || c == ']'; }));
    before = word;
  }
  return names;
}

// Between two blanks or more, or tabs: columns that are padded to a width.
std::vector<std::string> padded_names(std::string_view line) {
  std::vector<std::string> names;
  line = trimmed(line);
  while (!line.empty()) {
    const std::size_t end = std::min(line.find("  "), line.find('\t'));
    names.emplace_back(trimmed(line.substr(0, end)));
    line = end == std::string_view::npos ? std::string_view() : trimmed(line.substr(end));
  }
  return names;
}

std::vector<std::string> separated_names(std::string_view line, Separator separator) {
  std::vector<std::string> names;
  for (const std::string_view field : split_fields(line, separator)) {
    std::string& name = names.emplace_back(field);
    for (auto at = name.find("\"\""); at != std::string::npos; at = name.find("\"\"", at + 1))
      name.erase(at, 1);
  }
  return names;
}

// As many names as there are columns: columns that hold nothing need none. Nothing if there are
// others.
bool fit(std::vector<std::string>& names, const TextTable& table, std::size_t count) {
  if (names.size() == count + 1 && names[0].ends_with(':')) names.erase(names.begin());
  while (names.size() > count && names.back().empty()) names.pop_back();
  if (names.size() > count || names.empty()) return false;
  const bool are_columns = count == table.columns.size();
  for (std::size_t i = names.size(); i < count; ++i)
    if (!are_columns || table.columns[i] != TextTable::Column::kEmpty) return false;
  names.resize(count);
  return true;
}

std::optional<std::vector<std::string>> names_of(const TextTable::HeadingLine& line,
                                                 const TextTable& table, std::size_t count) {
  std::vector<std::vector<std::string>> all{separated_names(line.text, table.separator)};
  for (const Separator separator : kSeparators) {
    if (separator != Separator::kBlanks && separator != table.separator &&
        line.text.find(static_cast<char>(separator)) != std::string::npos)
      all.push_back(separated_names(line.text, separator));
  }
  const bool is_blanks = table.separator == Separator::kBlanks;
  all.insert(is_blanks ? all.begin() : all.end(), padded_names(line.text));
  all.push_back(merged_words(line.text));
  all.push_back(separated_names(line.text, Separator::kBlanks));
  for (std::vector<std::string>& names : all) {
    if (!fit(names, table, count)) continue;
    const bool has_number = std::any_of(names.begin(), names.end(), [](const std::string& name) {
      return !name.empty() && parse_field(name).has_value();
    });
    if (line.is_comment && has_number) continue;  // a comment about something else
    return names;
  }
  return std::nullopt;
}

bool name_positions(const std::vector<std::string>& names) {
  std::vector<PointColumn> columns;
  columns.reserve(names.size());
  for (const std::string& name : names) columns.push_back({name});
  return has_position_names(columns);
}

// Looks at line after line.
class TableLook {
 public:
  explicit TableLook(const LineReader& lines) : lines_(lines) {}

  const TextTable& table() const noexcept { return table_; }
  bool is_done() const noexcept { return table_.num_lines >= TextTable::kMostLines; }

  void look_at(std::string_view line) {
    const TextComment comment = comment_in(line);
    if (comment.is_comment) {
      if (table_.num_lines == 0) add_heading(comment.text, true);
    } else if (table_.num_lines > 0) {
      look_at_row(split_fields(line, table_.separator));
    } else if (!begins(line)) {
      look_at_text(line);
    }
  }

 private:
  void add_heading(std::string_view text, bool is_comment) {
    if (table_.heading.size() == kMostHeadingLines) table_.heading.erase(table_.heading.begin());
    table_.heading.push_back({std::string(text.substr(0, kLongestHeadingLine)), is_comment});
  }

  void look_at_text(std::string_view line) {
    const std::string begin = lower(trimmed(line.substr(0, 40)));
    for (const char* const word : {"title", "variables", "zone"}) {
      if (!begin.starts_with(word)) continue;
      const auto next = begin.find_first_not_of(" \t", std::string_view(word).size());
      if (next == std::string::npos || begin[next] != '=') continue;
      throw Error(ErrorCode::kUnsupported,
                  fmt::format("{}: is a Tecplot file, which is not read: expected a table whose "
                              "first line names the columns, as its data are exported to CSV",
                              lines_.where()));
    }
    if (++table_.num_text_lines > kMostTextLines) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: '{}': expected at least three numbers for x, y, z in one of the "
                              "first lines",
                              lines_.where(), line.substr(0, 40)));
    }
    // Spreadsheets say first what separates the fields.
    std::string_view said = trimmed(line);
    if (said.size() > 2 && said.front() == '"') said = said.substr(1, said.find('"', 1) - 1);
    if (table_.num_text_lines == 1 && said.size() == 5 && lower(said.substr(0, 4)) == "sep=") {
      for (const Separator separator : kSeparators)
        if (said[4] == static_cast<char>(separator)) said_ = separator;
      if (said_) return;
    }
    add_heading(line, false);
  }

  // Is it the first line of numbers? Then it says what separates the fields: what makes as many of
  // them as there are names, else the first that makes three numbers.
  bool begins(std::string_view line) {
    std::optional<FieldLayout> found;
    for (const Separator separator : kSeparators) {
      if (said_ && separator != *said_) continue;
      if (separator != Separator::kBlanks &&
          line.find(static_cast<char>(separator)) == std::string_view::npos)
        continue;
      FieldLayout layout = lay_out(line, separator);
      if (!is_row(layout)) continue;
      const bool fits = has_as_many_names(layout);
      if (!found || fits) found = std::move(layout);
      if (fits) break;
    }
    if (!found) return false;
    table_.separator = found->separator;
    table_.mark = found->mark;
    // A last field may be empty in this line, and not in others.
    if (found->separator != Separator::kBlanks &&
        trimmed_end(line).ends_with(static_cast<char>(found->separator)) &&
        has_names(found->fields.size() + 1, found->separator))
      found->fields.emplace_back();
    table_.columns.resize(found->fields.size());
    look_at_row(found->fields);
    return true;
  }

  static std::string_view trimmed_end(std::string_view line) {
    while (line.ends_with(' ')) line.remove_suffix(1);
    return line;
  }

  // Three numbers, or as many places where the line before names x, y and z.
  bool is_row(const FieldLayout& layout) const {
    if (layout.num_numbers >= kLeastNumbers && layout.has_value) return true;
    if (table_.heading.empty() || layout.fields.size() < 3) return false;
    const std::vector<std::string> names =
        separated_names(table_.heading.back().text, layout.separator);
    return names.size() == layout.fields.size() && layout.num_numbers > 0 &&
           std::all_of(layout.fields.begin(), layout.fields.end(),
                       [&](std::string_view field) {
                         return parse_field(field, layout.mark).has_value() &&
                                field.find_first_not_of('-') != std::string_view::npos;
                       }) &&
           name_positions(names);
  }

  bool has_names(std::size_t count, Separator separator) const {
    return std::any_of(table_.heading.begin(), table_.heading.end(), [&](const auto& line) {
      return separated_names(line.text, separator).size() == count;
    });
  }

  bool has_as_many_names(const FieldLayout& layout) const {
    return has_names(layout.fields.size(), layout.separator);
  }

  void look_at_row(const std::vector<std::string_view>& fields) {
    ++table_.num_lines;
    const std::size_t count = std::min(fields.size(), table_.columns.size());
    for (std::size_t i = 0; i < count; ++i) {
      auto number = parse_field(fields[i], table_.mark);
      const bool has_no_other_marks =
          table_.separator == Separator::kComma || !parse_field(fields[i], DecimalMark::kComma);
      if (!number && has_no_other_marks) refuse_thousands(lines_.where(), fields[i]);
      if (!number && !has_points_ && table_.mark == DecimalMark::kPoint) {
        // Whole numbers came first.
        number = parse_field(fields[i], DecimalMark::kComma);
        if (number) table_.mark = DecimalMark::kComma;
      }
      has_points_ = has_points_ || (number && fields[i].find('.') != std::string_view::npos);
      if (table_.columns[i] != TextTable::Column::kEmpty) continue;
      if (!number)
        table_.columns[i] = TextTable::Column::kText;
      else if (!std::isnan(*number))
        table_.columns[i] = TextTable::Column::kNumbers;
    }
  }

  const LineReader& lines_;
  TextTable table_;
  std::optional<Separator> said_;
  bool has_points_ = false;  // numbers with decimal points were seen
};

// Which line of the heading names the columns; its size if none does.
struct NameLine {
  std::size_t index = 0;
  std::vector<std::string> names;
};

NameLine find_names(const TextTable& table, std::size_t count) {
  const std::size_t none = table.heading.size();
  NameLine found{none, {}};
  for (std::size_t i = none; i-- > 0;) {
    const TextTable::HeadingLine& line = table.heading[i];
    auto names = names_of(line, table, count);
    if (!names) continue;
    if (name_positions(*names)) return {i, std::move(*names)};
    // Else the last line, or the last comment right before the numbers.
    const bool is_better = found.index == none
                               ? !line.is_comment || i + 1 == none
                               : table.heading[found.index].is_comment && !line.is_comment;
    if (is_better) found = {i, std::move(*names)};
  }
  return found;
}

// A line of units below that of names.
bool add_units(const TextTable& table, std::size_t index, std::vector<std::string>& names) {
  if (index >= table.heading.size() || table.heading[index].is_comment) return false;
  const auto units = separated_names(table.heading[index].text, table.separator);
  if (units.size() > names.size() || units.size() + 1 < names.size()) return false;
  for (std::size_t i = 0; i < units.size(); ++i) {
    if (units[i].empty() || names[i].empty()) continue;
    std::string unit = units[i];
    std::erase_if(unit, [](char c) { return c == '(' || c == ')' || c == '[' || c == ']'; });
    names[i] += fmt::format(" [{}]", trimmed(unit));
  }
  return true;
}

}  // namespace

void refuse_thousands(const std::string& where, std::string_view text) {
  if (!has_thousands_marks(text)) return;
  throw Error(ErrorCode::kFileFormat,
              fmt::format("{}: '{}': numbers with marks between their thousands are not read: "
                          "expected them without",
                          where, text.substr(0, 32)));
}

TextTable look_at_table(const ByteSource& source) {
  const std::string start = stream_start(source, 2);
  if (start == "\xff\xfe" || start == "\xfe\xff") {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: is text in UTF-16, which is not read: expected UTF-8, which "
                            "spreadsheets save as 'CSV UTF-8'",
                            source.name()));
  }
  const ReadOptions options;
  ReadProgress progress(options, 0);
  const auto stream = open_stream(source, progress);
  LineReader lines(*stream, source.name());
  TextRows rows(lines);
  TableLook look(lines);
  for (std::string_view line; !look.is_done() && rows.next(line);) look.look_at(line);
  if (look.table().num_lines == 0) {
    throw Error(
        ErrorCode::kFileFormat,
        fmt::format("{}: holds no line of numbers: expected rows of x, y, z", source.name()));
  }
  return look.table();
}

std::vector<std::string> names_in(const std::string& where, const TextTable& table,
                                  std::int64_t count, std::vector<std::string>& notes) {
  NameLine found = find_names(table, static_cast<std::size_t>(count));
  const bool has_units = add_units(table, found.index + 1, found.names);
  std::vector<std::string> passed;
  for (std::size_t i = 0; i < table.heading.size(); ++i) {
    const bool is_used = i == found.index || (has_units && i == found.index + 1);
    if (!table.heading[i].is_comment && !is_used)
      passed.push_back(table.heading[i].text.substr(0, 60));
  }
  if (passed.size() == 1 && found.names.empty()) {
    notes.push_back(fmt::format("{}: the line of names '{}' does not have {} of them: ignored",
                                where, passed[0], count));
  } else if (!passed.empty()) {
    notes.push_back(fmt::format("{}: {} passed over: '{}'{}", where,
                                passed.size() == 1
                                    ? std::string("a line before the numbers is")
                                    : fmt::format("{} lines before the numbers are", passed.size()),
                                passed[0], passed.size() == 1 ? "" : " and others"));
  }
  found.names.resize(static_cast<std::size_t>(count));
  return std::move(found.names);
}

}  // namespace ovoid::io
