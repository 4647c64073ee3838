// SPDX-License-Identifier: Apache-2.0
// Walks a legacy file as VTK 9's reader does, which minds no lines between its words but takes one
// away before binary data, and measures every array against what is left of the file. Where the
// reader would go on with whatever it finds (a word too long for it, a keyword begun like a known
// one, metadata of a form that depends on what is linked), the file is refused, so that both see
// the same arrays.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/core/samples.h"
#include "io/core/text_scanner.h"
#include "io/foreign/legacy_vtk_types.h"
#include "io/foreign/vtk_header.h"
#include "io/foreign/vtk_header_parts.h"

namespace ovoid::io {
namespace {

class LegacyChecker {
 public:
  explicit LegacyChecker(const ByteSource& source)
      : source_(source), text_(source, 0, source.size()) {}

  VtkGrid run() {
    const std::string magic = text_.line().value_or("");
    text_.line();  // title
    const std::string encoding = keyword();
    if (encoding != "ascii" && encoding != "binary")
      fail(fmt::format("'{}' after the title: expected ASCII or BINARY", shown(encoding)));
    is_binary_ = encoding == "binary";
    const std::string dataset = keyword();
    if (dataset != "dataset")
      fail(fmt::format("'{}' after the encoding: expected DATASET", shown(dataset)));
    const std::string kind = keyword();
    static const std::map<std::string, VtkGrid> kGrids{
        {"structured_points", VtkGrid::kImage},
        {"rectilinear_grid", VtkGrid::kRectilinear},
        {"structured_grid", VtkGrid::kStructured},
        {"unstructured_grid", VtkGrid::kUnstructured},
        {"polydata", VtkGrid::kPolyData}};
    const auto found = kGrids.find(kind);
    if (found == kGrids.end()) {
      fail(fmt::format("DATASET '{}': expected STRUCTURED_POINTS, RECTILINEAR_GRID, "
                       "STRUCTURED_GRID, UNSTRUCTURED_GRID or POLYDATA",
                       shown(kind)),
           ErrorCode::kUnsupported);
    }
    grid_ = found->second;
    has_dims_ = grid_ != VtkGrid::kUnstructured && grid_ != VtkGrid::kPolyData;
    if (!has_dims_) num_cells_ = 0;  // so far
    if (grid_ >= VtkGrid::kStructured) read_version(magic);
    for (std::string word = keyword(); !word.empty(); word = keyword()) check_part(word);
    if (has_dims_ && num_tuples_ < 0)
      fail("has no POINT_DATA or CELL_DATA: is the file truncated?");
    if (grid_ >= VtkGrid::kStructured && !has_points_) fail("has no POINTS");
    if (grid_ == VtkGrid::kUnstructured && !cell_lists_.empty() && !has_types_)
      fail("has CELLS and no CELL_TYPES: is the file truncated?");
    return grid_;
  }

 private:
  [[noreturn]] void fail(const std::string& what, ErrorCode code = ErrorCode::kFileFormat) const {
    fail_header(source_, what, code);
  }

  // For a message, which a zero would end.
  static std::string shown(std::string_view text, std::size_t size = 40) {
    std::string result(text.substr(0, size));
    std::replace(result.begin(), result.end(), '\0', '?');
    return result;
  }

  // The next word as it stands; empty at the end.
  std::string word() {
    const std::string_view text = text_.word();
    if (text.size() > TextScanner::kLongestWord) {
      fail(fmt::format("'{}...': expected a word of at most {} characters", shown(text),
                       TextScanner::kLongestWord));
    }
    return std::string(text);
  }
  std::string keyword() { return lower(word()); }

  std::int64_t integer(const std::string& what, std::int64_t least, std::int64_t most) {
    const std::string text = word();
    const auto value = parse_integer(text);
    if (!value || *value < least || *value > most)
      fail(fmt::format("{}: '{}': expected {} to {}", what, shown(text), least, most));
    return *value;
  }

  // "# vtk DataFile Version 5.1": from 5 on cells are stored in another way.
  void read_version(const std::string& magic) {
    constexpr std::string_view kStart = "# vtk DataFile Version ";
    const std::string version =
        magic.starts_with(kStart)
            ? magic.substr(kStart.size(), magic.find_last_not_of(" \t\r") + 1 - kStart.size())
            : "";
    const bool is_known = version.size() == 3 && version[0] >= '1' && version[0] <= '5' &&
                          version[1] == '.' && version[2] >= '0' && version[2] <= '9';
    if (!is_known) fail(fmt::format("'{}': expected version 1.0 to 5.9", shown(magic, 80)));
    has_offsets_ = version[0] == '5';
  }

  // What may stand behind DATASET: the image's place, then its arrays.
  void check_part(const std::string& word) {
    if (word == "point_data" || word == "cell_data") return begin_arrays(word == "point_data");
    if (word == "field") return check_field();
    if (num_tuples_ >= 0) return check_attribute(word);
    if (word == "dimensions" && has_dims_) return read_dimensions();
    if (grid_ == VtkGrid::kStructured || !has_dims_) return check_mesh_part(word);
    if (grid_ == VtkGrid::kRectilinear) return check_coordinates(word);
    if (word == "spacing" || word == "aspect_ratio") return check_vector("SPACING");
    if (word == "origin") return check_vector("ORIGIN");
    fail(fmt::format("'{}': expected DIMENSIONS, SPACING, ORIGIN, FIELD, POINT_DATA or CELL_DATA",
                     shown(word)));
  }

  // X_COORDINATES count type, then numbers
  void check_coordinates(const std::string& word) {
    const std::size_t axis = num_coordinates_;
    constexpr std::array<const char*, 3> kWords{"x_coordinates", "y_coordinates", "z_coordinates"};
    constexpr std::array<const char*, 3> kNames{"X_COORDINATES", "Y_COORDINATES", "Z_COORDINATES"};
    if (axis == 3 || word != kWords[axis]) {
      fail(fmt::format("'{}': expected {}, FIELD, POINT_DATA or CELL_DATA", shown(word),
                       axis == 3 ? "no more coordinates" : kNames[axis]));
    }
    if (!num_points_) fail(fmt::format("{} before DIMENSIONS", kNames[axis]));
    LegacyArray array;
    array.what = kNames[axis];
    array.num_tuples = integer(array.what, 1, kMaxAxisSize);
    if (array.num_tuples != dims_[axis]) {
      fail(fmt::format("{}: {} of them: DIMENSIONS need {}", array.what, array.num_tuples,
                       dims_[axis]));
    }
    array.type = keyword();
    if (array.type == "bit") fail(fmt::format("{}: type 'bit': expected numbers", array.what));
    check_numbers(array);
    ++num_coordinates_;
  }

  // What may stand before the arrays of a mesh.
  void check_mesh_part(const std::string& word) {
    if (word == "points") return check_points();
    if (grid_ == VtkGrid::kUnstructured && word == "cells") return check_cells("CELLS");
    if (grid_ == VtkGrid::kUnstructured && word == "cell_types") return check_cell_types();
    if (grid_ == VtkGrid::kPolyData) {
      for (const char* const name : {"VERTICES", "LINES", "POLYGONS", "TRIANGLE_STRIPS"}) {
        if (word == lower(name)) return check_cells(name);
      }
    }
    fail(
        fmt::format("'{}': expected POINTS, CELLS, CELL_TYPES, VERTICES, LINES, POLYGONS, "
                    "TRIANGLE_STRIPS, DIMENSIONS, FIELD, POINT_DATA or CELL_DATA, as the kind of "
                    "data set has them",
                    shown(word)));
  }

  // POINTS count type, then three numbers each
  void check_points() {
    if (has_points_) fail("POINTS: stand twice");
    has_points_ = true;
    LegacyArray array;
    array.what = "POINTS";
    array.num_tuples = integer(array.what, 0, kMaxAxisSize);
    array.num_components = 3;
    array.type = keyword();
    if (array.type == "bit") fail("POINTS: type 'bit': expected numbers");
    if (!has_dims_) num_points_ = array.num_tuples;
    if (!num_points_) fail("POINTS before DIMENSIONS");
    if (array.num_tuples != *num_points_)
      fail(fmt::format("POINTS: {} of them: DIMENSIONS need {}", array.num_tuples, *num_points_));
    check_numbers(array);
  }

  // CELLS num_cells size: `size` integers, for each cell the number of its nodes, then these. From
  // version 5 on: CELLS num_offsets num_nodes, OFFSETS type, CONNECTIVITY type.
  void check_cells(const std::string& name) {
    if (!num_points_) fail(fmt::format("{} before POINTS", name));
    if (std::find(cell_lists_.begin(), cell_lists_.end(), name) != cell_lists_.end())
      fail(fmt::format("{}: stand twice", name));
    cell_lists_.push_back(name);
    LegacyArray array;
    array.what = name;
    array.type = "int";
    const std::int64_t count = integer(name, 0, kMaxAxisSize);
    array.num_tuples = integer(name, 0, kMaxNumBytes);
    if (has_offsets_) {
      check_offsets(name, count, array.num_tuples);
      *num_cells_ += std::max<std::int64_t>(count - 1, 0);
      return;
    }
    *num_cells_ += count;
    const std::int64_t num_values = checked_num_values(array);
    if (is_binary_ && num_values > 0) {
      pass_line_end(array);
      if (num_values > text_.num_left() / 4) fail_to_fit(array);
    }
    // VTK walks from count to count and looks at nothing else.
    std::int64_t num_walked = 0;
    for (std::int64_t c = 0; c < count; ++c) {
      const std::int64_t num_nodes = num_walked < num_values ? next_int(array) : -1;
      if (num_nodes < 0 || num_nodes > num_values - num_walked - 1) {
        fail(fmt::format("{}: cell {} has {} nodes: {} of {} numbers are left", name, c, num_nodes,
                         std::max<std::int64_t>(num_values - num_walked - 1, 0), num_values));
      }
      for (std::int64_t i = 0; i < num_nodes; ++i) check_node(array, next_int(array));
      num_walked += num_nodes + 1;
    }
    if (num_walked != num_values)
      fail(fmt::format("{}: {} cells take {} of {} numbers", name, count, num_walked, num_values));
  }

  void check_node(const LegacyArray& array, std::int64_t node) const {
    if (node >= 0 && node < *num_points_) return;
    fail(fmt::format("{}: node {}: there are {} POINTS", array.what, node, *num_points_));
  }

  // One of the integers of a list of cells.
  std::int64_t next_int(const LegacyArray& array) {
    if (is_binary_) {
      std::uint32_t value = 0;
      for (const char c : text_.ahead(4)) value = value << 8U | static_cast<unsigned char>(c);
      text_.skip(4);
      return static_cast<std::int32_t>(value);
    }
    const std::string text = word();
    const auto value = parse_integer(text);
    if (!value) fail(fmt::format("{}: '{}': expected an integer", array.what, shown(text)));
    return *value;
  }

  void check_offsets(const std::string& name, std::int64_t num_offsets, std::int64_t num_nodes) {
    if (num_offsets == 0 && num_nodes == 0) return;
    for (const bool are_offsets : {true, false}) {
      const char* const expected = are_offsets ? "offsets" : "connectivity";
      const std::string word = keyword();
      if (word != expected) fail(fmt::format("{}: '{}': expected {}", name, shown(word), expected));
      LegacyArray array;
      array.what = fmt::format("{} {}", name, expected);
      array.num_tuples = are_offsets ? num_offsets : num_nodes;
      array.type = keyword();
      if (array.type != "vtktypeint64" && array.type != "int" && array.type != "vtkidtype" &&
          array.type != "long") {
        fail(fmt::format("{}: type '{}': expected vtktypeint64", array.what, shown(array.type)));
      }
      check_numbers(array);
    }
  }

  // CELL_TYPES count, then an integer each
  void check_cell_types() {
    LegacyArray array;
    array.what = "CELL_TYPES";
    array.num_tuples = integer(array.what, 0, kMaxAxisSize);
    array.type = "int";
    if (cell_lists_.empty() || has_types_ || array.num_tuples != *num_cells_)
      fail(fmt::format("CELL_TYPES: {} of them behind {} CELLS", array.num_tuples, *num_cells_));
    has_types_ = true;
    pass_values(array);
  }

  void read_dimensions() {
    if (num_points_) fail("DIMENSIONS: stand twice");
    for (std::int64_t& dim : dims_) dim = integer("DIMENSIONS", 1, kMaxAxisSize);
    num_points_ = num_points(source_, "DIMENSIONS", dims_);
    num_cells_ = num_cells(dims_);
  }

  void check_vector(const char* field) {
    for (int i = 0; i < 3; ++i) {
      const std::string text = word();
      if (!is_number(text, NumberKind::kReal))
        fail(fmt::format("{}: '{}': expected three numbers", field, shown(text)));
    }
  }

  void begin_arrays(bool is_of_points) {
    const char* const keyword = is_of_points ? "POINT_DATA" : "CELL_DATA";
    bool& is_seen = is_of_points ? has_point_data_ : has_cell_data_;
    // The reader calls itself for each section.
    if (is_seen) fail(fmt::format("{}: stands twice", keyword));
    is_seen = true;
    const auto expected = is_of_points ? num_points_ : num_cells_;
    if (!expected) fail(fmt::format("{} before {}", keyword, has_dims_ ? "DIMENSIONS" : "POINTS"));
    if (grid_ == VtkGrid::kRectilinear && num_coordinates_ < 3)
      fail(fmt::format("{} before the coordinates along all three axes", keyword));
    const std::string text = word();
    if (parse_integer(text) != expected)
      fail(fmt::format("{}: '{}': {} need {}", keyword, shown(text),
                       has_dims_ ? "DIMENSIONS" : "POINTS and CELLS", *expected));
    // A bit is the smallest sample there is.
    if (*expected / 8 > source_.size()) {
      fail(fmt::format("{}: {} samples do not fit a file of {} bytes: is it truncated?", keyword,
                       *expected, source_.size()));
    }
    num_tuples_ = *expected;
  }

  void check_attribute(const std::string& keyword) {
    if (keyword == "scalars") return check_scalars();
    if (keyword == "color_scalars") return check_color_scalars();
    if (keyword == "texture_coordinates") return check_texture_coordinates();
    if (keyword == "lookup_table") return check_lookup_table();
    static const std::map<std::string, std::int64_t> kNumComponents{
        {"vectors", 3},    {"normals", 3},      {"tensors", 9},   {"tensors6", 6},
        {"global_ids", 1}, {"pedigree_ids", 1}, {"edge_flags", 1}};
    const auto found = kNumComponents.find(keyword);
    if (found == kNumComponents.end()) {
      fail(fmt::format("'{}' behind the arrays: expected SCALARS, VECTORS, FIELD or another array",
                       shown(keyword)));
    }
    LegacyArray array = named_array();
    array.type = this->keyword();
    array.num_components = found->second;
    check_numbers(array);
  }

  LegacyArray named_array() {
    LegacyArray array;
    array.what = fmt::format("array '{}'", shown(word(), 80));
    array.num_tuples = num_tuples_;
    return array;
  }

  // SCALARS name type [components] LOOKUP_TABLE table
  void check_scalars() {
    LegacyArray array = named_array();
    array.type = keyword();
    std::string next = keyword();
    if (next != "lookup_table") {
      const auto num_components = parse_integer(next);
      if (!num_components || *num_components < 1 || *num_components > kMaxVtkComponents) {
        fail(fmt::format("{}: '{}': expected a number of components or LOOKUP_TABLE", array.what,
                         shown(next)));
      }
      array.num_components = *num_components;
      next = keyword();
    }
    if (next != "lookup_table")
      fail(fmt::format("{}: '{}': expected LOOKUP_TABLE default", array.what, shown(next)));
    word();  // the table's name
    check_numbers(array);
  }

  // COLOR_SCALARS name components; bytes, or numbers from 0 to 1 as text
  void check_color_scalars() {
    LegacyArray array = named_array();
    array.num_components = integer(array.what, 1, kMaxVtkComponents);
    array.type = is_binary_ ? "unsigned_char" : "float";
    check_numbers(array);
  }

  // TEXTURE_COORDINATES name dimension type
  void check_texture_coordinates() {
    LegacyArray array = named_array();
    array.num_components = integer(array.what, 1, 3);
    array.type = keyword();
    check_numbers(array);
  }

  // LOOKUP_TABLE name size; four bytes each, or four numbers as text. No array, but read like one.
  void check_lookup_table() {
    LegacyArray table;
    table.what = fmt::format("LOOKUP_TABLE '{}'", shown(word(), 80));
    table.num_tuples = integer(table.what, 0, kMaxAxisSize);
    table.num_components = 4;
    table.type = is_binary_ ? "unsigned_char" : "float";
    pass_values(table);
  }

  // FIELD name count, then arrays: name components tuples type
  void check_field() {
    const std::string what = fmt::format("FIELD '{}'", shown(word(), 80));
    const std::int64_t num_arrays = integer(what, 0, kMaxVtkArrays);
    for (std::int64_t i = 0; i < num_arrays; ++i) {
      const std::string name = word();
      if (name == "NULL_ARRAY") continue;
      LegacyArray array;
      array.what = fmt::format("array '{}'", shown(name, 80));
      array.num_components = integer(array.what, 1, kMaxVtkComponents);
      array.num_tuples = integer(array.what, 0, kMaxNumBytes);
      array.type = keyword();
      if (is_legacy_text(array.type)) {
        pass_strings(array);
        pass_metadata(array);
      } else {
        check_numbers(array);
      }
    }
  }

  // Passes an array of numbers and what may follow it.
  void check_numbers(const LegacyArray& array) {
    if (++num_arrays_ > kMaxVtkArrays)
      fail(fmt::format("has more than {} arrays", kMaxVtkArrays), ErrorCode::kUnsupported);
    if (!find_legacy_type(array.type)) {
      fail(
          fmt::format("{}: type '{}': expected char, short, int, long, float or another of VTK's "
                      "types of numbers",
                      array.what, shown(array.type)));
    }
    pass_values(array);
    pass_metadata(array);
  }

  void pass_values(const LegacyArray& array) {
    const std::int64_t num_values = checked_num_values(array);
    if (num_values == 0) return;
    const ValueType type = *find_legacy_type(array.type);
    if (!is_binary_) return pass_text(array, num_values, type.kind);
    pass_line_end(array);
    const auto num_bytes = type.size == 0 ? std::optional((num_values + 7) / 8)
                                          : checked_product(std::array{num_values, type.size});
    if (!num_bytes || *num_bytes > text_.num_left()) fail_to_fit(array);
    text_.skip(*num_bytes);
  }

  std::int64_t checked_num_values(const LegacyArray& array) const {
    const auto num_values = checked_product(std::array{array.num_tuples, array.num_components});
    // Even a bit as text takes a digit, and as a byte an eighth of it.
    if (!num_values || *num_values / 8 > text_.num_left()) fail_to_fit(array);
    return *num_values;
  }

  void pass_text(const LegacyArray& array, std::int64_t num_values, NumberKind kind) {
    // A digit and a blank for every number but the last.
    if (num_values - 1 > text_.num_left() / 2) fail_to_fit(array);
    for (std::int64_t i = 0; i < num_values; ++i) {
      const std::string_view text = text_.word();
      if (is_number(text, kind)) continue;
      if (text.empty()) {
        fail(fmt::format("{}: ends after {} of {} numbers: is the file truncated?", array.what, i,
                         num_values));
      }
      fail(fmt::format("{}: '{}' after {} of {} numbers: expected a number of type {}", array.what,
                       shown(text), i, num_values, array.type));
    }
  }

  // The reader takes the rest of a line away before binary data, if it is short enough.
  void pass_line_end(const LegacyArray& array) {
    const auto end = text_.ahead(TextScanner::kLongestWord).find('\n');
    if (end == std::string_view::npos)
      fail(fmt::format("{}: its line does not end before the data", array.what));
    text_.skip(static_cast<std::int64_t>(end) + 1);
  }

  void pass_strings(const LegacyArray& array) {
    const std::int64_t num_values = checked_num_values(array);
    if (is_binary_)
      pass_line_end(array);
    else
      text_.line();
    for (std::int64_t i = 0; i < num_values; ++i) {
      if (text_.num_left() == 0) fail_to_fit(array);
      if (!is_binary_ || array.type == "variant") {
        text_.line();
        continue;
      }
      const std::int64_t num_bytes = read_string_size(array);
      if (num_bytes > text_.num_left()) fail_to_fit(array);
      text_.skip(num_bytes);
    }
  }

  // The first two bits tell how long the length is, which is in the others, big endian.
  std::int64_t read_string_size(const LegacyArray& array) {
    const auto first = static_cast<unsigned char>(text_.ahead(1)[0]);
    constexpr std::array<std::int64_t, 4> kNumBytes{8, 4, 2, 1};
    const std::int64_t num_bytes = kNumBytes[first >> 6U];
    if (num_bytes > text_.num_left()) fail_to_fit(array);
    std::int64_t size = first & 0x3fU;
    for (const char c : text_.ahead(static_cast<std::size_t>(num_bytes)).substr(1))
      size = size << 8U | static_cast<unsigned char>(c);
    text_.skip(num_bytes);
    return size;
  }

  // Behind an array: empty lines, then perhaps METADATA.
  void pass_metadata(const LegacyArray& array) {
    while (true) {
      const std::string_view text = text_.ahead(TextScanner::kLongestWord + 1);
      const auto begin = text.find_first_not_of(" \r");
      if (begin == std::string_view::npos && text.size() > TextScanner::kLongestWord) {
        // VTK looks at these again and again.
        fail(fmt::format("{}: followed by more than {} blanks", array.what,
                         TextScanner::kLongestWord));
      }
      if (begin == std::string_view::npos || text[begin] != '\n') break;
      text_.skip(static_cast<std::int64_t>(begin) + 1);
    }
    if (lower(text_.ahead(8)) != "metadata") return;
    text_.line();
    for (std::string line = metadata_line(array); !line.empty(); line = metadata_line(array)) {
      const auto parts = words(line);
      if (lower(parts[0]) == "component_names" && parts.size() == 1) {
        for (std::int64_t i = 0; i < array.num_components; ++i) {
          if (text_.num_left() == 0) fail_metadata(array, "COMPONENT_NAMES");
          text_.line();
        }
      } else if (lower(parts[0]) == "information" && parts.size() == 2) {
        pass_information(array, line);
      } else {
        fail_metadata(array, line);
      }
    }
  }

  // A line of metadata, empty where they end.
  std::string metadata_line(const LegacyArray& array) {
    std::string line = text_.line().value_or("");
    if (line.ends_with('\r')) line.pop_back();
    const bool is_plain = line.find('\0') == std::string::npos && line.size() < 255;
    if (!is_plain || (!line.empty() && is_blank(line[0]))) fail_metadata(array, line);
    return line;
  }

  // INFORMATION count, then for each "NAME key LOCATION class" and "DATA values". How VTK reads the
  // values depends on the key; here all ways must end with the line.
  void pass_information(const LegacyArray& array, const std::string& head) {
    const auto count = parse_integer(words(head)[1]);
    if (!count || *count < 0) fail_metadata(array, head);
    for (std::int64_t i = 0; i < *count; ++i) {
      const std::string name = metadata_line(array);
      if (!name.starts_with("NAME ")) fail_metadata(array, name);
      const std::string data = metadata_line(array);
      const auto parts = words(data);
      if (parts.size() < 2 || parts[0] != "DATA") fail_metadata(array, data);
      if (name.starts_with("NAME UNITS_LABEL LOCATION vtkDataArray")) continue;  // a text
      // A single value, or how many there are and then these.
      const auto num_values = parse_integer(parts[1]);
      const bool is_text = !is_number(parts[1].substr(0, 1), NumberKind::kInteger) &&
                           parts[1][0] != '-' && parts[1][0] != '+';
      const bool is_list = num_values && *num_values > 0 &&
                           *num_values <= static_cast<std::int64_t>(parts.size()) - 2;
      if (!is_text && !is_list) fail_metadata(array, data);
    }
  }

  [[noreturn]] void fail_metadata(const LegacyArray& array, const std::string& line) const {
    fail(fmt::format("{}: METADATA: '{}': not understood, or the file is truncated", array.what,
                     shown(line)));
  }

  [[noreturn]] void fail_to_fit(const LegacyArray& array) const {
    fail(fmt::format(
        "{}: {} tuples of {} {} do not fit the {} bytes behind it: is the file "
        "truncated?",
        array.what, array.num_tuples, array.num_components, shown(array.type), text_.num_left()));
  }

  const ByteSource& source_;
  TextScanner text_;
  VtkGrid grid_ = VtkGrid::kImage;
  std::array<std::int64_t, 3> dims_{};
  std::size_t num_coordinates_ = 0;  // axes whose coordinates have been passed
  bool is_binary_ = false;
  bool has_offsets_ = false;  // cells as from version 5 on
  bool has_dims_ = true;      // else POINTS and lists of cells say how many there are
  bool has_points_ = false;
  bool has_types_ = false;
  std::vector<std::string> cell_lists_;  // those that have been passed
  bool has_point_data_ = false;
  bool has_cell_data_ = false;
  std::optional<std::int64_t> num_points_, num_cells_;
  std::int64_t num_tuples_ = -1;  // of the section's arrays; -1 before the first
  std::int64_t num_arrays_ = 0;
};

}  // namespace

VtkGrid check_legacy_vtk(const ByteSource& source) { return LegacyChecker(source).run(); }

}  // namespace ovoid::io
