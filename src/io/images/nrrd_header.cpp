// SPDX-License-Identifier: Apache-2.0
#include "io/images/nrrd_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>
#include <utility>

#include "io/core/header_lines.h"
#include "io/core/samples.h"
#include "io/core/text_scanner.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr int kMaxDimension = 16;  // NRRD_DIM_MAX
constexpr int kMostSpace = 4;      // time or another parameter as the fourth

// One "field: value" line and where it stands, for messages.
struct NrrdField : HeaderField {
  template <typename T>
  T number(std::string_view text, const char* expected) const {
    const auto result = parse_number<T>(text);
    if (!result) fail(fmt::format("'{}': expected {}", text.substr(0, 40), expected));
    return *result;
  }

  // The value's words, exactly one for each axis.
  std::vector<std::string_view> per_axis(std::size_t num_axes) const {
    auto result = words(value);
    if (result.size() != num_axes)
      fail(fmt::format("{} has {} entries: expected {}", quoted(), result.size(), num_axes));
    return result;
  }
};

struct HeaderText {
  std::map<std::string, NrrdField> fields;  // by canonical name
  std::vector<std::string> list;            // lines after "data file: LIST"
  std::optional<std::int64_t> data_offset;  // after the blank line, if there is one
  std::map<std::string, std::string> sequence_keys;
  bool is_segmentation = false;
};

// The format's own names of fields, each of which may be written without its blanks, too.
std::string canonical_name(std::string_view name) {
  static constexpr const char* kSpaced[] = {
      "data file",        "line skip",    "byte skip",   "sample units",     "axis mins",
      "axis maxs",        "block size",   "old min",     "old max",          "space dimension",
      "space directions", "space origin", "space units", "measurement frame"};
  std::string result = lower(trimmed(name));
  if (result == "centerings") return "centers";
  for (const char* const spaced : kSpaced) {
    std::string joined = spaced;
    std::erase(joined, ' ');
    if (result == joined) return spaced;
  }
  return result;
}

// Of the keys, which are free for other programs, those that say how axes are to be taken.
void keep_key(std::string_view line, std::size_t colon, HeaderText& text) {
  const std::string_view key = trimmed(line.substr(0, colon));
  constexpr std::string_view kSegment = "Segment";
  if (key.starts_with(kSegment) && key.size() > kSegment.size() &&
      std::isdigit(static_cast<unsigned char>(key[kSegment.size()])) != 0)
    text.is_segmentation = true;
  constexpr std::size_t kMostKeys = 64;
  const bool is_of_sequence =
      (key.starts_with("axis ") && key.find(" index ") != std::string_view::npos) ||
      key == "MultiVolume.FrameLabels" || key == "MultiVolume.FrameIdentifyingDICOMTagUnits";
  if (is_of_sequence && text.sequence_keys.size() < kMostKeys)
    text.sequence_keys.emplace(key, trimmed(line.substr(colon + 2)));
}

HeaderText read_text(const ByteSource& source) {
  HeaderText result;
  HeaderLines reader(source);
  std::string line;
  reader.next(line);
  if (!looks_like_nrrd(line) || line.size() != 8 || line[7] < '1' || line[7] > '5' ||
      line.substr(4, 3) != "000") {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: starts with '{}': expected NRRD0001 to NRRD0005", source.name(),
                            line.substr(0, 16)));
  }
  bool is_list = false;
  while (reader.next(line)) {
    if (line.empty()) {
      result.data_offset = reader.offset();
      return result;
    }
    if (is_list) {
      result.list.emplace_back(trimmed(line));
      continue;
    }
    const auto colon = line.find(':');
    if (line.front() == '#') continue;
    if (colon == std::string::npos) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: line {}: '{}' is no 'field: value' line", source.name(),
                              reader.number(), line.substr(0, 80)));
    }
    if (line.compare(colon, 2, ":=") == 0) {
      keep_key(line, colon, result);
      continue;
    }
    NrrdField field{{&source, reader.number(), canonical_name(line.substr(0, colon)),
                     std::string(trimmed(std::string_view(line).substr(colon + 1)))}};
    is_list = field.name == "data file" && words(field.value).size() <= 2 &&
              field.value.starts_with("LIST");
    const auto [existing, is_new] = result.fields.emplace(field.name, field);
    if (!is_new) field.fail(fmt::format("stands twice, first on line {}", existing->second.line));
  }
  return result;
}

ScalarType parse_type(const NrrdField& field) {
  static const std::map<std::string, ScalarType, std::less<>> kTypes{
      {"signed char", ScalarType::kInt8},
      {"int8", ScalarType::kInt8},
      {"int8_t", ScalarType::kInt8},
      {"uchar", ScalarType::kUInt8},
      {"unsigned char", ScalarType::kUInt8},
      {"uint8", ScalarType::kUInt8},
      {"uint8_t", ScalarType::kUInt8},
      {"short", ScalarType::kInt16},
      {"short int", ScalarType::kInt16},
      {"signed short", ScalarType::kInt16},
      {"signed short int", ScalarType::kInt16},
      {"int16", ScalarType::kInt16},
      {"int16_t", ScalarType::kInt16},
      {"ushort", ScalarType::kUInt16},
      {"unsigned short", ScalarType::kUInt16},
      {"unsigned short int", ScalarType::kUInt16},
      {"uint16", ScalarType::kUInt16},
      {"uint16_t", ScalarType::kUInt16},
      {"int", ScalarType::kInt32},
      {"signed int", ScalarType::kInt32},
      {"int32", ScalarType::kInt32},
      {"int32_t", ScalarType::kInt32},
      {"uint", ScalarType::kUInt32},
      {"unsigned int", ScalarType::kUInt32},
      {"uint32", ScalarType::kUInt32},
      {"uint32_t", ScalarType::kUInt32},
      {"longlong", ScalarType::kInt64},
      {"long long", ScalarType::kInt64},
      {"long long int", ScalarType::kInt64},
      {"signed long long", ScalarType::kInt64},
      {"signed long long int", ScalarType::kInt64},
      {"int64", ScalarType::kInt64},
      {"int64_t", ScalarType::kInt64},
      {"ulonglong", ScalarType::kUInt64},
      {"unsigned long long", ScalarType::kUInt64},
      {"unsigned long long int", ScalarType::kUInt64},
      {"uint64", ScalarType::kUInt64},
      {"uint64_t", ScalarType::kUInt64},
      {"float", ScalarType::kFloat32},
      {"double", ScalarType::kFloat64}};
  const auto found = kTypes.find(fmt::format("{}", fmt::join(words(lower(field.value)), " ")));
  if (found != kTypes.end()) return found->second;
  if (lower(field.value) == "block")
    field.fail("blocks of bytes are not numbers", ErrorCode::kUnsupported);
  field.fail(fmt::format(
      "{}: expected a type such as uchar, int8, short, uint16, int, uint32, int64, float or double",
      field.quoted()));
}

Encoding parse_encoding(const NrrdField& field) {
  static const std::map<std::string, Encoding, std::less<>> kEncodings{
      {"raw", Encoding::kRaw},    {"txt", Encoding::kText},  {"text", Encoding::kText},
      {"ascii", Encoding::kText}, {"hex", Encoding::kHex},   {"gz", Encoding::kGzip},
      {"gzip", Encoding::kGzip},  {"bz2", Encoding::kBzip2}, {"bzip2", Encoding::kBzip2}};
  const auto found = kEncodings.find(lower(field.value));
  if (found == kEncodings.end()) {
    field.fail(fmt::format("{}: expected raw, gzip, bzip2, ascii or hex", field.quoted()),
               ErrorCode::kUnsupported);
  }
  return found->second;
}

// "left-posterior-superior", "left posterior superior", "LeftPosteriorSuperior" and "LPS" are one
// space; sets name and dimension.
void parse_space(const NrrdField& field, NrrdHeader& header) {
  static constexpr std::pair<const char*, const char*> kSpaces[] = {
      {"right-anterior-superior", "ras"},
      {"left-anterior-superior", "las"},
      {"left-posterior-superior", "lps"},
      {"scanner-xyz", ""},
      {"3D-right-handed", ""},
      {"3D-left-handed", ""}};
  const auto plain = [](std::string_view text) {
    std::string result = lower(text);
    std::erase_if(result, [](char c) { return c == '-' || c == ' ' || c == '\t'; });
    return result;
  };
  const std::string name = plain(field.value);
  for (const auto& [full, abbreviation] : kSpaces) {
    for (const bool has_time : {false, true}) {
      const std::string in_full = std::string(full) + (has_time ? "-time" : "");
      const std::string in_short = std::string(abbreviation) + (has_time ? "t" : "");
      if (name != plain(in_full) && (*abbreviation == '\0' || name != in_short)) continue;
      header.space = in_full;
      header.space_dimension = has_time ? 4 : 3;
      return;
    }
  }
  field.fail(
      fmt::format("{}: expected a space such as left-posterior-superior, RAS or 3D-right-handed",
                  field.quoted()));
}

// Vectors "(x,y,z)" of up to four numbers and, where allowed, "none". Components beyond the space's
// are not accepted, missing ones (a plane) are 0.
using NrrdVector = std::array<double, 4>;
std::vector<std::optional<NrrdVector>> parse_vectors(const NrrdField& field, int dimension) {
  std::vector<std::optional<NrrdVector>> result;
  std::string_view rest = trimmed(field.value);
  while (!rest.empty()) {
    if (lower(rest.substr(0, 4)) == "none") {
      result.emplace_back();
      rest = trimmed(rest.substr(4));
      continue;
    }
    const auto close = rest.find(')');
    if (rest.front() != '(' || close == std::string_view::npos) {
      field.fail(fmt::format("{}: expected vectors such as (1,0,0)", field.quoted()));
    }
    std::string inside(rest.substr(1, close - 1));
    rest = trimmed(rest.substr(close + 1));
    if (static_cast<int>(std::count(inside.begin(), inside.end(), ',')) != dimension - 1) {
      field.fail(fmt::format("({}): expected {} numbers", inside.substr(0, 80), dimension));
    }
    std::replace(inside.begin(), inside.end(), ',', ' ');
    const auto numbers = words(inside);
    if (static_cast<int>(numbers.size()) != dimension) {
      field.fail(fmt::format("({}): expected {} numbers", inside.substr(0, 80), dimension));
    }
    NrrdVector vector{};
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      vector[i] = field.number<double>(numbers[i], "a number");
      if (!std::isfinite(vector[i]))
        field.fail(fmt::format("{}: expected finite numbers", field.quoted()));
    }
    result.emplace_back(vector);
  }
  return result;
}

int parse_subdimension(const NrrdField& field, std::string_view word, std::size_t dimension) {
  const int result = field.number<int>(word, "a number of axes");
  if (result < 1 || result > static_cast<int>(dimension)) {
    field.fail(fmt::format("{} axes in one file: expected 1 to {}", result, dimension));
  }
  return result;
}

DataFiles parse_data_files(const NrrdField& field, const HeaderText& text, std::size_t dimension) {
  DataFiles files;
  const auto parts = words(field.value);
  if (parts.empty()) field.fail("is empty: expected a file name");
  if (parts[0] == "LIST" && parts.size() <= 2) {
    files.names = text.list;
    files.count = static_cast<std::int64_t>(files.names.size());
    if (files.count == 0) field.fail("LIST: no file names follow");
    if (parts.size() == 2) files.subdimension = parse_subdimension(field, parts[1], dimension);
    return files;
  }
  // A pattern has no blanks in it, as its numbers are told from it by them; anything else is one
  // name, blanks included.
  if ((parts.size() == 4 || parts.size() == 5) && parse_number<std::int64_t>(parts[1]) &&
      parse_numbered_name(parts[0], files)) {
    constexpr const char* kExpected = "'name%d.raw MIN MAX STEP'";
    const auto first = field.number<std::int32_t>(parts[1], kExpected);
    const auto last = field.number<std::int32_t>(parts[2], kExpected);
    const auto step = field.number<std::int32_t>(parts[3], kExpected);
    if (!number_files(files, first, last, step)) {
      field.fail(
          fmt::format("{}: the step leads from {} away from {}", field.quoted(), first, last));
    }
    if (parts.size() == 5) files.subdimension = parse_subdimension(field, parts[4], dimension);
    return files;
  }
  files.names = {field.value};
  files.count = 1;
  return files;
}

std::string unquoted(std::string_view text) {
  text = trimmed(text);
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"')
    text = text.substr(1, text.size() - 2);
  return std::string(text);
}

// Texts in quotes, as the format writes one for each axis; of others the words.
std::vector<std::string> quoted_texts(std::string_view text) {
  std::vector<std::string> result;
  while (!(text = trimmed(text)).empty()) {
    const bool is_quoted = text.front() == '"';
    if (is_quoted) text.remove_prefix(1);
    std::size_t end = 0;
    while (end < text.size() && (is_quoted ? text[end] != '"' : !is_blank(text[end]))) ++end;
    result.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(text.size(), end + 1));
  }
  return result;
}

// Does a matrix, its columns as vectors, turn nothing? What cannot be read says nothing.
bool turns_vectors(std::string_view value) {
  std::string text(value);
  for (char& c : text)
    if (c == '(' || c == ')' || c == ',') c = ' ';
  const auto numbers = words(text);
  if (numbers.size() != 9) return false;
  constexpr double kSame = 1e-6;
  for (std::size_t i = 0; i < 9; ++i) {
    const auto number = parse_number<double>(numbers[i]);
    if (number && std::abs(*number - (i % 4 == 0 ? 1 : 0)) > kSame) return true;
  }
  return false;
}

// Fields that say nothing about the samples' values or places, or that are restated by others.
bool is_ignored(const std::string& name) {
  static constexpr const char* kIgnored[] = {"number",  "min",        "max",    "old min",
                                             "old max", "block size", "labels", "thicknesses"};
  return std::find(std::begin(kIgnored), std::end(kIgnored), name) != std::end(kIgnored);
}

// Interprets the fields one by one; taken ones are removed, what is left over is not understood.
class Interpreter {
 public:
  Interpreter(const ByteSource& source, HeaderText text)
      : source_(source), text_(std::move(text)) {}

  NrrdHeader run() {
    const std::size_t dimension = read_axes();
    header_.type = parse_type(required("type"));
    header_.encoding = parse_encoding(required("encoding"));
    if (const auto field = take("endian")) read_endian(*field);
    read_per_axis(dimension);
    read_space(dimension);
    if (const auto field = take("content")) header_.content = unquoted(field->value);
    if (const auto field = take("sample units")) header_.unit = unquoted(field->value);
    read_data_position(dimension);
    header_.sequence_keys = std::move(text_.sequence_keys);
    header_.is_segmentation = text_.is_segmentation;
    for (const auto& [name, field] : text_.fields) {
      if (!is_ignored(name)) {
        header_.notes.push_back(fmt::format("{}: line {}: field '{}' is not known and ignored",
                                            source_.name(), field.line, name));
      }
    }
    return std::move(header_);
  }

 private:
  std::optional<NrrdField> take(const char* name) {
    auto node = text_.fields.extract(name);
    if (node.empty()) return std::nullopt;
    return std::move(node.mapped());
  }

  NrrdField required(const char* name) {
    auto field = take(name);
    if (!field)
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: the header has no field '{}'", source_.name(), name));
    return *std::move(field);
  }

  std::size_t read_axes() {
    const NrrdField dimension_field = required("dimension");
    const int dimension = dimension_field.number<int>(dimension_field.value, "a number of axes");
    if (dimension < 1 || dimension > kMaxDimension) {
      dimension_field.fail(fmt::format("{}: expected 1 to {}", dimension, kMaxDimension));
    }
    const NrrdField sizes = required("sizes");
    for (const auto word : sizes.per_axis(static_cast<std::size_t>(dimension))) {
      NrrdAxis axis;
      axis.size = sizes.number<std::int64_t>(word, "a number of samples");
      if (axis.size < 1 || axis.size > kMaxAxisSize)
        sizes.fail(fmt::format("{}: expected 1 to {}", axis.size, kMaxAxisSize));
      header_.axes.push_back(axis);
    }
    return header_.axes.size();
  }

  void read_endian(const NrrdField& field) {
    const std::string value = lower(field.value);
    if (value != "little" && value != "big")
      field.fail(fmt::format("{}: expected little or big", field.quoted()));
    header_.is_big_endian = value == "big";
  }

  void read_doubles(const char* name, std::size_t dimension,
                    std::optional<double> NrrdAxis::*member) {
    const auto field = take(name);
    if (!field) return;
    const auto parts = field->per_axis(dimension);
    for (std::size_t i = 0; i < dimension; ++i) {
      const double value = field->number<double>(parts[i], "a number");
      if (std::isinf(value))
        field->fail(fmt::format("{}: expected finite numbers", field->quoted()));
      if (!std::isnan(value)) header_.axes[i].*member = value;  // nan: not known
    }
  }

  void read_per_axis(std::size_t dimension) {
    read_doubles("spacings", dimension, &NrrdAxis::spacing);
    read_doubles("axis mins", dimension, &NrrdAxis::min);
    read_doubles("axis maxs", dimension, &NrrdAxis::max);
    if (const auto field = take("kinds")) {
      const auto parts = field->per_axis(dimension);
      for (std::size_t i = 0; i < dimension; ++i) header_.axes[i].kind = lower(parts[i]);
    }
    if (const auto field = take("centers")) {
      const auto parts = field->per_axis(dimension);
      for (std::size_t i = 0; i < dimension; ++i) {
        const std::string value = lower(parts[i]);
        header_.has_centers = header_.has_centers || value == "node" || value == "cell";
        header_.axes[i].is_node_centered = value == "node";
      }
    }
    if (const auto field = take("units")) {
      const std::vector<std::string> units = quoted_texts(field->value);
      for (std::size_t i = 0; i < std::min(dimension, units.size()); ++i)
        header_.axes[i].unit = units[i];
    }
  }

  void read_space(std::size_t dimension) {
    const auto name = take("space");
    if (name) parse_space(*name, header_);
    if (const auto field = take("space dimension")) {
      const int value = field->number<int>(field->value, "a number");
      if (value < 1 || value > kMaxDimension)
        field->fail(fmt::format("{}: expected 1 to {}", value, kMaxDimension));
      if (name && value != header_.space_dimension)
        field->fail(
            fmt::format("{}: space '{}' has {}", value, header_.space, header_.space_dimension));
      header_.space_dimension = value;
    }
    const auto directions = take("space directions");
    const auto origin = take("space origin");
    for (const auto* field : {&directions, &origin}) {
      if (!*field) continue;
      if (header_.space_dimension == 0)
        (*field)->fail("needs a 'space' or 'space dimension' field");
      if (header_.space_dimension > kMostSpace)
        (*field)->fail(fmt::format("a space of {} dimensions: expected 2, 3, or 4 with time",
                                   header_.space_dimension),
                       ErrorCode::kUnsupported);
    }
    if (directions) {
      const auto vectors = parse_vectors(*directions, header_.space_dimension);
      if (vectors.size() != dimension) {
        directions->fail(fmt::format("{} has {} entries: expected {}", directions->quoted(),
                                     vectors.size(), dimension));
      }
      header_.has_directions = true;
      for (std::size_t i = 0; i < dimension; ++i) {
        if (!vectors[i]) continue;
        const auto [x, y, z, fourth] = *vectors[i];
        header_.axes[i].direction = {x, y, z};
        if (header_.space_dimension == kMostSpace) header_.axes[i].fourth = fourth;
      }
    }
    if (origin) {
      const auto vectors = parse_vectors(*origin, header_.space_dimension);
      if (vectors.size() != 1 || !vectors[0])
        origin->fail(fmt::format("{}: expected one vector", origin->quoted()));
      const auto [x, y, z, fourth] = *vectors[0];
      header_.origin = {x, y, z};
      if (header_.space_dimension == kMostSpace) header_.origin_fourth = fourth;
    }
    if (const auto field = take("space units")) header_.space_units = quoted_texts(field->value);
    if (const auto field = take("measurement frame"))
      header_.has_turned_frame = turns_vectors(field->value);
  }

  std::int64_t read_skip(const char* name, std::int64_t least) {
    const auto field = take(name);
    if (!field) return 0;
    const auto value = field->number<std::int64_t>(field->value, "a number");
    if (value < least || value > kMaxNumBytes)
      field->fail(fmt::format("{}: expected at least {}", value, least));
    if (value < 0 && header_.encoding != Encoding::kRaw) {
      field->fail(fmt::format("{}: only raw data can be counted from the end, encoding is {}",
                              value, name_of(header_.encoding)));
    }
    return value;
  }

  void read_data_position(std::size_t dimension) {
    header_.line_skip = read_skip("line skip", 0);
    header_.byte_skip = read_skip("byte skip", -1);
    if (const auto field = take("data file")) {
      header_.files = parse_data_files(*field, text_, dimension);
      return;
    }
    if (!text_.data_offset) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: the header ends without a blank line and names no data file",
                              source_.name()));
    }
    header_.data_offset = *text_.data_offset;
  }

  const ByteSource& source_;
  HeaderText text_;
  NrrdHeader header_;
};

}  // namespace

bool looks_like_nrrd(std::string_view start) noexcept { return start.starts_with("NRRD"); }

NrrdHeader read_nrrd_header(const ByteSource& source) {
  return Interpreter(source, read_text(source)).run();
}

}  // namespace ovoid::io
