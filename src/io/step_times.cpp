// SPDX-License-Identifier: Apache-2.0
#include "io/step_times.h"

#include <fmt/format.h>

#include <cmath>

#include "io/core/byte_stream.h"
#include "io/core/number_fields.h"
#include "io/core/text_scanner.h"
#include "io/core/xml_tags.h"
#include "io/formats.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// Where writers put the field data; what lies behind is not searched.
constexpr int kMaxTags = 200;
constexpr std::int64_t kMaxNumber = 256;  // bytes of one number as text

// Of the array's text, or else from the range that VTK states of every array: that of one number is
// the number, to 11 digits, and needs no decoding.
std::optional<double> number_of(const ByteSource& source, const XmlTag& tag) {
  if (tag.attribute("NumberOfTuples", "1") != "1") return std::nullopt;
  if (tag.attribute("format") == "ascii") {
    std::string text = source.text(tag.end, kMaxNumber);
    text.resize(std::min(text.size(), text.find('<')));
    const auto parts = words(text);
    return parts.size() == 1 ? parse_field(parts[0]) : std::nullopt;
  }
  const std::string least = tag.attribute("RangeMin");
  if (least.empty() || least != tag.attribute("RangeMax")) return std::nullopt;
  return parse_field(least);
}

}  // namespace

std::optional<double> time_of_vtk_xml(const ByteSource& source) {
  XmlTagReader reader(source);
  for (int i = 0; i < kMaxTags; ++i) {
    const auto tag = reader.next();
    if (!tag || tag->name == "Piece" || tag->name == "/FieldData") return std::nullopt;
    if (tag->name == "DataArray" && tag->attribute("Name") == "TimeValue")
      return number_of(source, *tag);
  }
  return std::nullopt;
}

std::optional<double> time_of_dump(const ByteSource& source) {
  std::string start = stream_start(source, 512);
  unify_line_ends(start);
  // In the simulation's units, else the number of the step.
  auto begin = start.find("ITEM: TIME\n");
  if (begin == std::string::npos) begin = start.find("ITEM: TIMESTEP");
  if (begin == std::string::npos) return std::nullopt;
  const auto line = start.find('\n', begin);
  const auto end = line == std::string::npos ? line : start.find('\n', line + 1);
  if (end == std::string::npos) return std::nullopt;
  const auto parts = words(std::string_view(start).substr(line + 1, end - line - 1));
  return parts.size() == 1 ? parse_field(parts[0]) : std::nullopt;
}

std::optional<double> named_time(const ByteSource& source) {
  const Format* const format = format_by_content(source);
  return format != nullptr && format->time != nullptr ? format->time(source) : std::nullopt;
}

void check_step_times(const std::vector<std::string>& files, const std::vector<double>& times) {
  const auto file = [&](std::size_t step) { return files[files.size() == 1 ? 0 : step]; };
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!std::isfinite(times[i])) {
      throw Error(
          ErrorCode::kFileFormat,
          fmt::format("{}: step {}: time {}: expected a finite number", file(i), i, times[i]));
    }
    if (i == 0 || times[i] > times[i - 1]) continue;
    const std::string before = files.size() == 1 ? fmt::format("step {}", i - 1)
                                                 : fmt::format("step {} ({})", i - 1, file(i - 1));
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: step {}: time {} is not after {}, the time of {}: expected rising "
                            "times",
                            file(i), i, times[i], times[i - 1], before));
  }
}

}  // namespace ovoid::io
