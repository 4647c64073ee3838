// SPDX-License-Identifier: Apache-2.0
#include "io/images/metaimage_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <utility>

#include "io/core/header_lines.h"
#include "io/core/samples.h"
#include "io/core/text_scanner.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// One "Field = value" line and where it stands, for messages.
struct MetaField : HeaderField {
  double real(std::string_view text) const {
    const auto number = parse_real(text);
    if (!number) fail(fmt::format("'{}': expected finite numbers", text.substr(0, 40)));
    return *number;
  }

  std::int64_t integer(std::string_view text, std::int64_t least, std::int64_t most) const {
    const auto number = parse_integer(text);
    if (!number || *number < least || *number > most)
      fail(fmt::format("'{}': expected {} to {}", text.substr(0, 40), least, most));
    return *number;
  }

  std::vector<std::string_view> parts(std::size_t count) const {
    auto result = words(value);
    if (result.size() != count)
      fail(fmt::format("{} has {} entries: expected {}", quoted(), result.size(), count));
    return result;
  }

  std::vector<double> reals(std::size_t count) const {
    std::vector<double> result;
    for (const std::string_view part : parts(count)) result.push_back(real(part));
    return result;
  }

  // The format looks at the first letter.
  bool truth() const {
    const char first = value.empty() ? ' ' : value[0];
    if (first == 'T' || first == 't' || first == '1') return true;
    if (first == 'F' || first == 'f' || first == '0') return false;
    fail(fmt::format("{}: expected True or False", quoted()));
  }
};

struct MetaText {
  std::map<std::string, MetaField> fields;
  std::vector<std::string> list;  // lines after "ElementDataFile = LIST"
  std::int64_t data_offset = 0;   // behind the line of ElementDataFile
};

// ElementDataFile ends the header, as the format has it.
MetaText read_meta_text(const ByteSource& source) {
  MetaText result;
  HeaderLines lines(source);
  std::string line;
  while (lines.next(line)) {
    if (trimmed(line).empty()) continue;
    const auto equals = line.find_first_of("=:");
    if (equals == std::string::npos) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: line {}: '{}' is no 'Field = value' line", source.name(),
                              lines.number(), line.substr(0, 80)));
    }
    MetaField field{{&source, lines.number(),
                     std::string(trimmed(std::string_view(line).substr(0, equals))),
                     std::string(trimmed(std::string_view(line).substr(equals + 1)))}};
    const bool is_last = field.name == "ElementDataFile";
    const bool is_list = is_last && field.value.starts_with("LIST");
    const auto [existing, is_new] = result.fields.emplace(field.name, field);
    // Comments may be many.
    if (!is_new && field.name != "Comment")
      field.fail(fmt::format("stands twice, first on line {}", existing->second.line));
    if (!is_last) continue;
    result.data_offset = lines.offset();
    while (is_list && lines.next(line)) {
      if (!trimmed(line).empty()) result.list.emplace_back(trimmed(line));
    }
    return result;
  }
  throw Error(ErrorCode::kFileFormat,
              fmt::format("{}: the header has no field 'ElementDataFile'", source.name()));
}

ScalarType parse_element_type(const MetaField& field) {
  static const std::map<std::string, ScalarType> kTypes{
      {"MET_CHAR", ScalarType::kInt8},         {"MET_ASCII_CHAR", ScalarType::kInt8},
      {"MET_UCHAR", ScalarType::kUInt8},       {"MET_SHORT", ScalarType::kInt16},
      {"MET_USHORT", ScalarType::kUInt16},     {"MET_INT", ScalarType::kInt32},
      {"MET_UINT", ScalarType::kUInt32},       {"MET_LONG", ScalarType::kInt32},
      {"MET_ULONG", ScalarType::kUInt32},      {"MET_LONG_LONG", ScalarType::kInt64},
      {"MET_ULONG_LONG", ScalarType::kUInt64}, {"MET_FLOAT", ScalarType::kFloat32},
      {"MET_DOUBLE", ScalarType::kFloat64}};
  std::string name = field.value;
  if (name.ends_with("_ARRAY")) name.resize(name.size() - 6);  // of channels
  const auto found = kTypes.find(name);
  if (found == kTypes.end()) {
    field.fail(
        fmt::format("{}: expected a type of numbers such as MET_UCHAR, MET_SHORT, MET_INT, "
                    "MET_FLOAT or MET_DOUBLE",
                    field.quoted()));
  }
  return found->second;
}

// Fields that say nothing about the samples' values or places, or that are restated by others.
bool says_nothing(const std::string& name) {
  static constexpr const char* kSilent[] = {"ObjectType",
                                            "ObjectSubType",
                                            "Comment",
                                            "TransformType",
                                            "ID",
                                            "ParentID",
                                            "Color",
                                            "Modality",
                                            "SequenceID",
                                            "ElementMin",
                                            "ElementMax",
                                            "ElementNBits",
                                            "ElementSize",
                                            "AcquisitionDate",
                                            "CompressionLevel",
                                            "AnatomicalOrientation",
                                            "ITK_InputFilterName"};
  return std::find(std::begin(kSilent), std::end(kSilent), name) != std::end(kSilent);
}

// Interprets the fields one by one; taken ones are removed, what is left over is not understood.
class MetaInterpreter {
 public:
  explicit MetaInterpreter(const ByteSource& source)
      : source_(source), text_(read_meta_text(source)) {}

  MetaImageHeader run() {
    if (const auto field = take({"ObjectType"}); field && field->value != "Image")
      field->fail(field->quoted() + ": expected Image", ErrorCode::kUnsupported);
    read_axes();
    header_.type = parse_element_type(required("ElementType"));
    if (const auto field = take({"ElementNumberOfChannels"}))
      header_.num_channels = static_cast<int>(field->integer(field->value, 1, 1'000'000));
    if (const auto field = take({"BinaryData"})) header_.is_binary = field->truth();
    if (const auto field = take({"BinaryDataByteOrderMSB", "ElementByteOrderMSB"}))
      header_.is_big_endian = field->truth();
    if (const auto field = take({"Name"})) header_.name = field->value;
    read_place();
    read_scale();
    read_storage();
    for (const auto& [name, field] : text_.fields) {
      if (says_nothing(name)) continue;
      header_.notes.push_back(fmt::format("{}: line {}: field '{}' is not known and ignored",
                                          source_.name(), field.line, name));
    }
    return std::move(header_);
  }

 private:
  // One of several names for the same thing.
  std::optional<MetaField> take(std::initializer_list<const char*> names) {
    std::optional<MetaField> result;
    for (const char* name : names) {
      auto node = text_.fields.extract(name);
      if (node.empty()) continue;
      if (result && result->value != node.mapped().value)
        node.mapped().fail(fmt::format("contradicts {}", result->name));
      result = std::move(node.mapped());
    }
    return result;
  }

  MetaField required(const char* name) {
    auto field = take({name});
    if (!field) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: the header has no field '{}'", source_.name(), name));
    }
    return *std::move(field);
  }

  void read_axes() {
    const MetaField num_axes = required("NDims");
    const std::int64_t count = num_axes.integer(num_axes.value, 1, 10);
    if (count < 2 || count > 4)
      num_axes.fail(fmt::format("{}: expected 2 to 4", count), ErrorCode::kUnsupported);
    num_axes_ = static_cast<std::size_t>(count);
    const MetaField sizes = required("DimSize");
    for (const std::string_view part : sizes.parts(num_axes_))
      header_.sizes.push_back(sizes.integer(part, 1, kMaxAxisSize));
  }

  void read_place() {
    header_.spacing.assign(num_axes_, 1.0);
    header_.offset.assign(num_axes_, 0.0);
    header_.directions.assign(num_axes_ * num_axes_, 0.0);
    for (std::size_t i = 0; i < num_axes_; ++i) header_.directions[i * (num_axes_ + 1)] = 1.0;
    // The size of an element is its spacing where that is not said.
    const auto size = take({"ElementSize"});
    const auto spacing = take({"ElementSpacing"});
    if (spacing || size) header_.spacing = (spacing ? spacing : size)->reals(num_axes_);
    if (const auto field = take({"Offset", "Position", "Origin", "ImagePosition"}))
      header_.offset = field->reals(num_axes_);
    if (const auto field = take({"TransformMatrix", "Rotation", "Orientation"}))
      header_.directions = field->reals(num_axes_ * num_axes_);
    if (const auto field = take({"CenterOfRotation", "CenterOfTransform"})) {
      const auto center = field->reals(num_axes_);
      if (std::any_of(center.begin(), center.end(), [](double x) { return x != 0; })) {
        header_.notes.push_back(fmt::format(
            "{}: line {}: {} is not 0 and ignored: Offset is the place of the first sample",
            source_.name(), field->line, field->name));
      }
    }
    if (const auto field = take({"DistanceUnits"});
        field && field->value != "mm" && field->value != "?") {
      header_.notes.push_back(fmt::format("{}: lengths are in {}, as the file has them",
                                          source_.name(), field->value.substr(0, 40)));
    }
  }

  void read_scale() {
    if (const auto field = take({"ElementToIntensityFunctionSlope"})) {
      header_.value_scale = field->real(field->value);
      if (header_.value_scale == 0) field->fail("0: expected another number");
    }
    if (const auto field = take({"ElementToIntensityFunctionOffset"}))
      header_.value_offset = field->real(field->value);
  }

  void read_storage() {
    if (const auto field = take({"CompressedData"})) header_.is_compressed = field->truth();
    if (const auto field = take({"CompressedDataSize"}))
      header_.compressed_size = field->integer(field->value, 0, kMaxNumBytes);
    if (const auto field = take({"HeaderSize"})) {
      header_.header_size = field->integer(field->value, -1, kMaxNumBytes);
      const bool is_raw = header_.is_binary && !header_.is_compressed;
      if (header_.header_size < 0 && !is_raw)
        field->fail("-1: only raw samples can be counted from the end of the file");
    }
    header_.data_offset = text_.data_offset;
    const MetaField field = required("ElementDataFile");
    if (lower(field.value) != "local") header_.files = parse_files(field);
    const bool is_inside = !header_.files && header_.header_size > 0;
    if (is_inside && header_.header_size < header_.data_offset)
      field.fail(fmt::format("LOCAL: HeaderSize {} ends within the header, which has {} bytes",
                             header_.header_size, header_.data_offset));
    if (is_inside) {
      header_.data_offset = header_.header_size;
      header_.header_size = 0;
    }
  }

  DataFiles parse_files(const MetaField& field) const {
    DataFiles files;
    const auto parts = words(field.value);
    if (parts.empty()) field.fail("is empty: expected a file name, LIST or LOCAL");
    if (parts[0] == "LIST" && parts.size() <= 2) {
      files.names = text_.list;
      files.count = static_cast<std::int64_t>(files.names.size());
      if (files.count == 0) field.fail("LIST: no file names follow");
      if (parts.size() == 1) {
        files.subdimension = static_cast<int>(num_axes_) - 1;
        return files;
      }
      std::string_view axes = parts[1];  // "2" or "2D"
      if (axes.ends_with('D')) axes.remove_suffix(1);
      files.subdimension =
          static_cast<int>(field.integer(axes, 1, static_cast<std::int64_t>(num_axes_)));
      return files;
    }
    if (parts.size() <= 4 && parse_numbered_name(parts[0], files)) {
      constexpr std::int64_t kLeast = INT32_MIN, kMost = INT32_MAX;
      std::array<std::int64_t, 3> numbers{1, 0, 1};  // first, last, step
      numbers[1] = std::min(header_.sizes.back(), kMost);
      for (std::size_t i = 1; i < parts.size(); ++i)
        numbers[i - 1] = field.integer(parts[i], kLeast, kMost);
      if (parts.size() == 2) numbers[1] = std::min(numbers[0] + header_.sizes.back() - 1, kMost);
      if (!number_files(files, static_cast<std::int32_t>(numbers[0]),
                        static_cast<std::int32_t>(numbers[1]),
                        static_cast<std::int32_t>(numbers[2]))) {
        field.fail(fmt::format("{}: the step leads from {} away from {}", field.quoted(),
                               numbers[0], numbers[1]));
      }
      files.subdimension = static_cast<int>(num_axes_) - 1;
      return files;
    }
    files.names = {field.value};
    files.count = 1;
    return files;
  }

  const ByteSource& source_;
  MetaText text_;
  std::size_t num_axes_ = 0;
  MetaImageHeader header_;
};

}  // namespace

bool looks_like_metaimage(std::string_view start) noexcept {
  // One of the first lines says how many axes there are.
  std::size_t begin = 0;
  for (int line = 0; line < 16 && begin < start.size(); ++line) {
    const std::size_t end = std::min(start.find_first_of("\r\n", begin), start.size());
    const std::string_view text = start.substr(begin, end - begin);
    if (text.find('\0') != std::string_view::npos) return false;
    const std::size_t equals = text.find_first_of("=:");
    if (equals != std::string_view::npos && trimmed(text.substr(0, equals)) == "NDims") return true;
    begin = end + 1;
  }
  return false;
}

MetaImageHeader read_metaimage_header(const ByteSource& source) {
  return MetaInterpreter(source).run();
}

}  // namespace ovoid::io
