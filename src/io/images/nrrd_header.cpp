// SPDX-License-Identifier: Apache-2.0
#include "io/images/nrrd_header.h"

#include <fmt/format.h>

#include <algorithm>
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
  std::vector<std::string> notes;
};

// The format's own alternative spellings.
std::string canonical_name(std::string_view name) {
  static const std::map<std::string, std::string, std::less<>> kAliases{
      {"datafile", "data file"}, {"lineskip", "line skip"},
      {"byteskip", "byte skip"}, {"sampleunits", "sample units"},
      {"axismins", "axis mins"}, {"axismaxs", "axis maxs"},
      {"centerings", "centers"}, {"blocksize", "block size"},
      {"oldmin", "old min"},     {"oldmax", "old max"}};
  const std::string result = lower(trimmed(name));
  const auto alias = kAliases.find(result);
  return alias == kAliases.end() ? result : alias->second;
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
    if (line.compare(colon, 2, ":=") == 0)
      continue;  // a key and its value: free for other programs
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

// "left-posterior-superior" and "LPS" are one space; sets name and dimension.
void parse_space(const NrrdField& field, NrrdHeader& header) {
  static const std::map<std::string, std::pair<const char*, int>, std::less<>> kSpaces{
      {"ras", {"right-anterior-superior", 3}},      {"las", {"left-anterior-superior", 3}},
      {"lps", {"left-posterior-superior", 3}},      {"rast", {"right-anterior-superior-time", 4}},
      {"last", {"left-anterior-superior-time", 4}}, {"lpst", {"left-posterior-superior-time", 4}}};
  static const std::map<std::string, int, std::less<>> kNames{{"right-anterior-superior", 3},
                                                              {"left-anterior-superior", 3},
                                                              {"left-posterior-superior", 3},
                                                              {"scanner-xyz", 3},
                                                              {"3d-right-handed", 3},
                                                              {"3d-left-handed", 3},
                                                              {"right-anterior-superior-time", 4},
                                                              {"left-anterior-superior-time", 4},
                                                              {"left-posterior-superior-time", 4},
                                                              {"scanner-xyz-time", 4},
                                                              {"3d-right-handed-time", 4},
                                                              {"3d-left-handed-time", 4}};
  const std::string name = lower(field.value);
  if (const auto abbreviation = kSpaces.find(name); abbreviation != kSpaces.end()) {
    header.space = abbreviation->second.first;
    header.space_dimension = abbreviation->second.second;
  } else if (const auto full = kNames.find(name); full != kNames.end()) {
    header.space = name;
    if (name.starts_with("3d")) header.space[1] = 'D';
    header.space_dimension = full->second;
  } else {
    field.fail(
        fmt::format("{}: expected a space such as left-posterior-superior, RAS or 3D-right-handed",
                    field.quoted()));
  }
}

// Vectors "(x,y,z)" and, where allowed, "none". Components beyond the space's are not accepted,
// missing ones (a plane) are 0.
std::vector<std::optional<std::array<double, 3>>> parse_vectors(const NrrdField& field,
                                                                int dimension) {
  std::vector<std::optional<std::array<double, 3>>> result;
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
    std::array<double, 3> vector{0, 0, 0};
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

// Fields that say nothing about the samples' values or places, or that are restated by others.
bool is_ignored(const std::string& name) {
  static constexpr const char* kIgnored[] = {
      "number", "min",   "max",         "old min",     "old max",          "block size",
      "labels", "units", "space units", "thicknesses", "measurement frame"};
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
      if (header_.space_dimension > 3)
        (*field)->fail(
            fmt::format("a space of {} dimensions: expected 2 or 3", header_.space_dimension),
            ErrorCode::kUnsupported);
    }
    if (directions) {
      const auto vectors = parse_vectors(*directions, header_.space_dimension);
      if (vectors.size() != dimension) {
        directions->fail(fmt::format("{} has {} entries: expected {}", directions->quoted(),
                                     vectors.size(), dimension));
      }
      header_.has_directions = true;
      for (std::size_t i = 0; i < dimension; ++i) header_.axes[i].direction = vectors[i];
    }
    if (origin) {
      const auto vectors = parse_vectors(*origin, header_.space_dimension);
      if (vectors.size() != 1 || !vectors[0])
        origin->fail(fmt::format("{}: expected one vector", origin->quoted()));
      header_.origin = vectors[0];
    }
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
