// SPDX-License-Identifier: Apache-2.0
#include "io/points/ply_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "io/core/header_lines.h"
#include "io/core/numbers.h"
#include "io/core/samples.h"
#include "io/core/text_scanner.h"
#include "ovoid/error.h"
#include "ovoid/kernel_field.h"

namespace ovoid::io {
namespace {

constexpr std::size_t kMaxPlyElements = 100;
constexpr std::size_t kMaxPlyProperties = 4096;
constexpr std::int64_t kMaxPlyCount = kMaxNumBytes >> 20;

std::optional<ScalarType> ply_type(std::string_view word) {
  static constexpr std::array<std::pair<std::string_view, ScalarType>, 16> kTypes{
      {{"char", ScalarType::kInt8},
       {"int8", ScalarType::kInt8},
       {"uchar", ScalarType::kUInt8},
       {"uint8", ScalarType::kUInt8},
       {"short", ScalarType::kInt16},
       {"int16", ScalarType::kInt16},
       {"ushort", ScalarType::kUInt16},
       {"uint16", ScalarType::kUInt16},
       {"int", ScalarType::kInt32},
       {"int32", ScalarType::kInt32},
       {"uint", ScalarType::kUInt32},
       {"uint32", ScalarType::kUInt32},
       {"float", ScalarType::kFloat32},
       {"float32", ScalarType::kFloat32},
       {"double", ScalarType::kFloat64},
       {"float64", ScalarType::kFloat64}}};
  const auto* const found = std::find_if(kTypes.begin(), kTypes.end(),
                                         [&](const auto& type) { return type.first == word; });
  return found == kTypes.end() ? std::nullopt : std::optional(found->second);
}

class PlyHeaderParser {
 public:
  explicit PlyHeaderParser(const ByteSource& source) : source_(source), lines_(source) {}

  PlyHeader run() {
    std::string line;
    lines_.next(line);  // "ply"
    bool has_format = false;
    while (true) {
      if (!lines_.next(line)) fail("the header has no 'end_header'");
      const std::vector<std::string_view> parts = words(line);
      if (parts.empty() || parts[0] == "obj_info") continue;
      if (parts[0] == "comment") {
        parse_comment(parts);
        continue;
      }
      if (parts[0] == "end_header") break;
      if (parts[0] == "format" && parts.size() >= 2) {
        parse_format(parts[1]);
        has_format = true;
      } else if (parts[0] == "element" && parts.size() == 3) {
        parse_element(parts);
      } else if (parts[0] == "property" && (parts.size() == 3 || parts.size() == 5)) {
        parse_property(parts);
      } else {
        fail(fmt::format("'{}': expected a format, an element or a property", line.substr(0, 60)));
      }
    }
    if (!has_format) fail("the header has no format");
    header_.data_offset = lines_.offset();
    header_.num_lines = lines_.number();
    return std::move(header_);
  }

 private:
  [[noreturn]] void fail(const std::string& what, ErrorCode code = ErrorCode::kFileFormat) const {
    throw Error(code,
                fmt::format("{}: PLY header, line {}: {}", source_.name(), lines_.number(), what));
  }

  // Comments are anybody's; those that begin with our name are ours.
  void parse_comment(const std::vector<std::string_view>& parts) {
    if (parts.size() != 4 || parts[1] != "ovoid") return;
    if (parts[2] == "reconstruction") {
      for (const Reconstruction how : {Reconstruction::kNormalized, Reconstruction::kSum}) {
        if (parts[3] == name_of(how)) header_.reconstruction = how;
      }
      if (!header_.reconstruction)
        fail(
            fmt::format("reconstruction '{}': expected normalized or sum", parts[3].substr(0, 40)));
    } else if (parts[2] == "cutoff") {
      header_.cutoff = parse_real(parts[3]);
      if (!header_.cutoff ||
          !(*header_.cutoff >= 1 && *header_.cutoff <= KernelColumns::kMaxCutoff))
        fail(fmt::format("cutoff '{}': expected 1 to {:g}", parts[3].substr(0, 40),
                         KernelColumns::kMaxCutoff));
    }
  }

  void parse_format(std::string_view name) {
    if (name == "ascii")
      header_.format = PlyHeader::Format::kAscii;
    else if (name == "binary_little_endian")
      header_.format = PlyHeader::Format::kLittleEndian;
    else if (name == "binary_big_endian")
      header_.format = PlyHeader::Format::kBigEndian;
    else
      fail(fmt::format("format '{}': expected ascii, binary_little_endian or binary_big_endian",
                       name.substr(0, 40)),
           ErrorCode::kUnsupported);
  }

  void parse_element(const std::vector<std::string_view>& parts) {
    const auto count = parse_integer(parts[2]);
    if (!count || *count < 0 || *count > kMaxPlyCount) {
      fail(fmt::format("element '{}' has '{}' records: expected 0 to {}", parts[1].substr(0, 40),
                       parts[2].substr(0, 40), kMaxPlyCount));
    }
    if (header_.elements.size() == kMaxPlyElements)
      fail(fmt::format("more than {} elements", kMaxPlyElements), ErrorCode::kUnsupported);
    header_.elements.push_back({std::string(parts[1]), *count, {}});
  }

  void parse_property(const std::vector<std::string_view>& parts) {
    if (header_.elements.empty()) fail("a property before the first element");
    PlyElement& element = header_.elements.back();
    if (element.properties.size() == kMaxPlyProperties)
      fail(fmt::format("more than {} properties", kMaxPlyProperties), ErrorCode::kUnsupported);
    PlyProperty property;
    property.is_list = parts.size() == 5;
    if (property.is_list && parts[1] != "list")
      fail(fmt::format("'{}': expected 'list'", parts[1].substr(0, 40)));
    property.type = type_of(parts[parts.size() - 2]);
    if (property.is_list) property.count_type = type_of(parts[2]);
    if (property.is_list && is_floating(property.count_type)) fail("a list whose count is a float");
    property.name = parts.back();
    for (const PlyProperty& other : element.properties)
      if (other.name == property.name)
        fail(fmt::format("property '{}' stands twice", property.name.substr(0, 40)));
    element.properties.push_back(std::move(property));
  }

  ScalarType type_of(std::string_view word) const {
    const auto type = ply_type(word);
    if (!type) fail(fmt::format("type '{}': expected char to double", word.substr(0, 40)));
    return *type;
  }

  const ByteSource& source_;
  HeaderLines lines_;
  PlyHeader header_;
};

}  // namespace

bool looks_like_ply(std::string_view start) noexcept {
  return start.starts_with("ply\n") || start.starts_with("ply\r");
}

bool PlyElement::has_lists() const noexcept {
  return std::any_of(properties.begin(), properties.end(),
                     [](const PlyProperty& property) { return property.is_list; });
}

std::int64_t PlyElement::row_size() const noexcept {
  std::int64_t size = 0;
  for (const PlyProperty& property : properties)
    size += static_cast<std::int64_t>(size_of(property.type));
  return size;
}

PlyHeader read_ply_header(const ByteSource& source) { return PlyHeaderParser(source).run(); }

}  // namespace ovoid::io
