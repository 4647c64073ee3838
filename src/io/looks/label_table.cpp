// SPDX-License-Identifier: Apache-2.0
// Names and colours of labels. What their files have in common: a line for each label, its number
// first. Behind it come a name and colours, or, in ITK-SNAP's, colours and a name in quotes. JSON
// is our own: {"1": "liver", "2": ["spleen", "#c05030", 0.5]}.
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <string_view>
#include <vector>

#include "io/core/byte_source.h"
#include "io/core/header_lines.h"
#include "io/core/json_file.h"
#include "io/core/numbers.h"
#include "io/core/text_file.h"
#include "io/core/text_scanner.h"
#include "io/images/nrrd_header.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid {
namespace {

constexpr std::size_t kMaxTableBytes = std::size_t{16} << 20;
constexpr double kMostInByte = 255;

struct TableLine {
  std::string_view path, text;
  int number = 0;  // from 1

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: line {}: {}", path, number, what));
  }
};

std::optional<int> label_in(std::string_view word) {
  const auto number = io::parse_integer(word);
  if (!number || *number < std::numeric_limits<int>::min() ||
      *number > std::numeric_limits<int>::max())
    return std::nullopt;
  return static_cast<int>(*number);
}

double byte_share(const TableLine& line, std::string_view word) {
  const auto number = io::parse_number<double>(word);
  if (!number || !(*number >= 0 && *number <= kMostInByte))
    line.fail(fmt::format("'{}': expected a colour from 0 to 255", word.substr(0, 40)));
  return *number / kMostInByte;
}

Rgb color_of(const TableLine& line, const std::vector<std::string_view>& words, std::size_t at) {
  return {byte_share(line, words[at]), byte_share(line, words[at + 1]),
          byte_share(line, words[at + 2])};
}

// IDX R G B A VIS MSH "LABEL"
LabelEntry snap_entry(const TableLine& line, int label) {
  const std::size_t quote = line.text.find('"');
  const std::size_t end = line.text.rfind('"');
  const auto words = io::words(line.text.substr(0, quote));
  if (words.size() < 6 || end == quote)
    line.fail("expected a number, red, green, blue, opacity, visibility and a name in quotes");
  LabelEntry entry;
  entry.label = label;
  entry.name = line.text.substr(quote + 1, end - quote - 1);
  entry.color = color_of(line, words, 1);
  const auto opacity = io::parse_number<double>(words[4]);
  if (!opacity || !(*opacity >= 0 && *opacity <= 1))
    line.fail(fmt::format("'{}': expected an opacity from 0 to 1", words[4].substr(0, 40)));
  const bool is_visible = words[5] != "0";
  entry.opacity = is_visible ? *opacity : 0;
  return entry;
}

// A number, a name, and perhaps red, green, blue and opacity.
LabelEntry named_entry(const TableLine& line, int label) {
  const auto words = io::words(line.text);
  std::size_t num_numbers = 0;
  while (num_numbers + 2 < words.size() &&
         io::parse_number<double>(words[words.size() - 1 - num_numbers]))
    ++num_numbers;
  LabelEntry entry;
  entry.label = label;
  num_numbers = std::min<std::size_t>(num_numbers, 4);
  const std::size_t num_names = words.size() - (num_numbers >= 3 ? num_numbers : 0);
  for (std::size_t i = 1; i < num_names; ++i) {
    // Codes behind a name are none of it.
    if (num_numbers < 3 && i > 1 && io::parse_number<double>(words[i])) continue;
    if (!entry.name.empty()) entry.name += ' ';
    entry.name += words[i];
  }
  if (num_numbers >= 3) entry.color = color_of(line, words, num_names);
  if (num_numbers == 4) entry.opacity = byte_share(line, words.back());
  return entry;
}

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  for (std::size_t from = 0; from <= line.size();) {
    const std::size_t end = std::min(line.find('\t', from), line.size());
    cells.push_back(io::trimmed(line.substr(from, end - from)));
    from = end + 1;
  }
  return cells;
}

std::optional<Rgb> hex_color(std::string_view text) {
  if (text.size() != 7 || text[0] != '#') return std::nullopt;
  Rgb rgb;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto number = io::exact_number<unsigned>(text.substr(1 + 2 * c, 2), 16);
    if (!number) return std::nullopt;
    rgb[c] = *number / kMostInByte;
  }
  return rgb;
}

// Columns by their titles, between tabs: "index", "name" and "color" (BIDS).
class TitledColumns {
 public:
  static std::optional<TitledColumns> of(std::string_view line) {
    TitledColumns columns;
    const auto titles = cells_of(line);
    for (std::size_t i = 0; i < titles.size(); ++i) columns.place_[io::lower(titles[i])] = i;
    if (!columns.place_.contains("index") || !columns.place_.contains("name")) return std::nullopt;
    return columns;
  }

  LabelEntry entry(const TableLine& line) const {
    const auto cells = cells_of(line.text);
    const auto cell = [&](const char* title) -> std::string_view {
      const auto at = place_.find(title);
      return at == place_.end() || at->second >= cells.size() ? "" : cells[at->second];
    };
    const auto label = label_in(cell("index"));
    if (!label) line.fail(fmt::format("'{}': expected a label", cell("index").substr(0, 40)));
    LabelEntry entry;
    entry.label = *label;
    entry.name = cell("name");
    entry.color = hex_color(cell("color"));
    return entry;
  }

 private:
  std::map<std::string, std::size_t> place_;
};

// FreeSurfer's tables have 0 for all opacities, and mean nothing by it.
void drop_meaningless_opacities(std::vector<LabelEntry>& entries) {
  const bool are_all_zero = std::all_of(entries.begin(), entries.end(), [](const LabelEntry& e) {
    return !e.opacity || *e.opacity == 0;
  });
  if (!are_all_zero) return;
  for (LabelEntry& entry : entries) entry.opacity.reset();
}

// A name, or a list of it, a colour and an opacity, of which the last may be missing.
LabelEntry json_entry(const io::JsonValue& value, int label) {
  LabelEntry entry;
  entry.label = label;
  if (value.json().is_string()) {
    entry.name = value.string();
    return entry;
  }
  if (!value.json().is_array() || value.size() < 1 || value.size() > 3)
    value.refuse("must be a name, or a name, a colour and an opacity");
  entry.name = value.element(0).string();
  if (value.size() > 1 && !value.element(1).json().is_null()) {
    entry.color = hex_color(value.element(1).string());
    if (!entry.color) value.element(1).refuse("must be a colour as #rrggbb, or null");
  }
  if (value.size() > 2) {
    entry.opacity = value.element(2).number();
    if (!(*entry.opacity >= 0 && *entry.opacity <= 1))
      value.element(2).refuse("must be an opacity from 0 to 1");
  }
  return entry;
}

std::vector<LabelEntry> entries_of_json(const std::string& text, const std::string& name) {
  const io::Json json = io::parse_json(text, name);
  const io::JsonValue root(json, name + ": ");
  std::vector<LabelEntry> entries;
  for (const auto& item : root.object().json().items()) {
    const auto label = label_in(item.key());
    const io::JsonValue value = root.member(item.key());
    if (!label) value.refuse("its name must be a label");
    entries.push_back(json_entry(value, *label));
  }
  return entries;
}

std::vector<LabelEntry> entries_of_rows(const std::string& text, const std::string& path) {
  std::vector<LabelEntry> entries;
  std::optional<TitledColumns> columns;
  bool is_snap = false;
  TableLine line{path, {}, 0};
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t end = std::min(text.find_first_of("\r\n", from), text.size());
    const std::string_view whole = std::string_view(text).substr(from, end - from);
    line.text = io::trimmed(whole);
    ++line.number;
    from = end + (text.compare(end, 2, "\r\n") == 0 ? 2 : 1);
    if (line.text.empty() || line.text[0] == '#') continue;
    if (columns) {
      line.text = whole;
      entries.push_back(columns->entry(line));
      continue;
    }
    if (entries.empty() && (columns = TitledColumns::of(whole))) continue;
    const auto label = label_in(io::words(line.text).front());
    if (!label) line.fail(fmt::format("'{}': expected a label", line.text.substr(0, 40)));
    is_snap = is_snap || line.text.find('"') != std::string_view::npos;
    entries.push_back(is_snap ? snap_entry(line, *label) : named_entry(line, *label));
  }
  if (!is_snap) drop_meaningless_opacities(entries);
  return entries;
}

std::vector<LabelEntry> entries_of_text(const std::string& text, const std::string& name) {
  return io::trimmed(text).starts_with('{') ? entries_of_json(text, name)
                                            : entries_of_rows(text, name);
}

// Of a segmentation, whose header has lines "Segment0_Name:=Liver".
std::vector<LabelEntry> entries_of_nrrd(const io::ByteSource& source, int layer) {
  struct Segment {
    LabelEntry entry;
    bool has_label = false;
    int layer = 0;
  };
  std::map<int, Segment> segments;
  io::HeaderLines lines(source);
  std::string text;
  while (lines.next(text) && !text.empty()) {
    constexpr std::string_view kPrefix = "Segment";
    const std::size_t equals = text.find(":=");
    if (!text.starts_with(kPrefix) || equals == std::string::npos) continue;
    const std::string_view key = std::string_view(text).substr(0, equals);
    const std::string_view value = std::string_view(text).substr(equals + 2);
    const std::size_t underscore = key.find('_');
    if (underscore == std::string_view::npos) continue;
    const auto number = label_in(key.substr(kPrefix.size(), underscore - kPrefix.size()));
    if (!number) continue;
    Segment& segment = segments[*number];
    const std::string_view what = key.substr(underscore + 1);
    const TableLine line{source.name(), value, lines.number()};
    if (what == "Name") {
      segment.entry.name = io::trimmed(value);
    } else if (what == "LabelValue") {
      const auto label = label_in(io::trimmed(value));
      if (!label) line.fail(fmt::format("'{}': expected a label", value.substr(0, 40)));
      segment.entry.label = *label;
      segment.has_label = true;
    } else if (what == "Layer") {
      segment.layer = label_in(io::trimmed(value)).value_or(0);
    } else if (what == "Color") {
      const auto words = io::words(value);
      Rgb rgb;
      for (std::size_t c = 0; c < 3; ++c) {
        const auto share = words.size() == 3 ? io::parse_number<double>(words[c]) : std::nullopt;
        if (!share || !(*share >= 0 && *share <= 1))
          line.fail(fmt::format("'{}': expected three numbers from 0 to 1", value.substr(0, 40)));
        rgb[c] = *share;
      }
      segment.entry.color = rgb;
    }
  }
  std::vector<LabelEntry> entries;
  for (const auto& [number, segment] : segments)
    if (segment.has_label && segment.layer == layer) entries.push_back(segment.entry);
  return entries;
}

// By number, of a label that is there twice the last.
std::vector<LabelEntry> table_of(std::vector<LabelEntry> all, const std::string& name) {
  if (all.empty()) {
    throw Error(
        ErrorCode::kFileFormat,
        fmt::format("{}: has no labels; expected lines of a number, a name and perhaps red, "
                    "green, blue and opacity (docs/labels.md)",
                    name));
  }
  std::map<int, LabelEntry> last;
  for (LabelEntry& entry : all) last[entry.label] = std::move(entry);
  std::vector<LabelEntry> entries;
  entries.reserve(last.size());
  for (auto& [label, entry] : last) entries.push_back(std::move(entry));
  return entries;
}

}  // namespace

std::vector<LabelEntry> label_table_from_text(const std::string& text,
                                              const std::string& source_name) {
  io::require_size(text.size(), kMaxTableBytes, source_name);
  return table_of(entries_of_text(text, source_name), source_name);
}

std::vector<LabelEntry> read_label_table(const std::string& path, int layer) {
  const auto source = io::open_file(path);
  std::array<char, 8> start{};
  const auto num = static_cast<std::size_t>(std::min<std::int64_t>(start.size(), source->size()));
  source->read(0, std::as_writable_bytes(std::span(start).first(num)));
  const bool is_nrrd = io::looks_like_nrrd({start.data(), num});
  return table_of(is_nrrd ? entries_of_nrrd(*source, layer)
                          : entries_of_text(io::read_text(path, kMaxTableBytes), path),
                  path);
}

}  // namespace ovoid
