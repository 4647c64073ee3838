// SPDX-License-Identifier: Apache-2.0
#include "io/vtk/vtk_set_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "io/core/numbers.h"
#include "io/core/xml_tags.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

struct SetType {
  std::string_view type;
  const char* format;
};
constexpr std::array<SetType, 10> kSetTypes{{{"PUnstructuredGrid", "PVTU"},
                                             {"PPolyData", "PVTP"},
                                             {"PStructuredGrid", "PVTS"},
                                             {"PRectilinearGrid", "PVTR"},
                                             {"PImageData", "PVTI"},
                                             {"vtkMultiBlockDataSet", "VTM"},
                                             {"vtkOverlappingAMR", "VTK AMR"},
                                             {"vtkNonOverlappingAMR", "VTK AMR"},
                                             {"vtkHierarchicalBoxDataSet", "VTK AMR"},
                                             {"Collection", "PVD"}}};

const SetType* find_set_type(const std::string& xml_type) noexcept {
  const auto found =
      std::find_if(kSetTypes.begin(), kSetTypes.end(),
                   [&](const SetType& candidate) { return candidate.type == xml_type; });
  return found == kSetTypes.end() ? nullptr : &*found;
}

// Text as the program means it that wrote the file.
std::string plain(const std::string& text) { return without_entities(text).value_or(text); }

double time_of(const ByteSource& source, const XmlTag& tag) {
  const std::string text = tag.attribute("timestep", "0");
  const auto value = parse_real(text);
  if (!value) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: DataSet: timestep=\"{}\": expected a finite number", source.name(),
                            text.substr(0, 40)));
  }
  return *value;
}

int level_of(const ByteSource& source, const XmlTag& tag) {
  const std::string text = tag.attribute("level", "0");
  const auto value = parse_number<int>(text);
  if (!value || *value < 0 || *value > 1000) {
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: Block: level=\"{}\": expected 0 to 1000",
                                                    source.name(), text.substr(0, 40)));
  }
  return *value;
}

}  // namespace

bool begins_like_vtk_xml(std::string_view start) noexcept {
  if (start.starts_with("\xef\xbb\xbf")) start.remove_prefix(3);  // a byte order mark
  const auto first = start.find_first_not_of(" \t\r\n");
  return first != std::string_view::npos && start[first] == '<' &&
         start.find("<VTKFile") != std::string_view::npos;
}

bool begins_like_legacy_vtk(std::string_view start) noexcept {
  return start.starts_with("# vtk DataFile");
}

std::string vtk_xml_type(const ByteSource& source) {
  XmlTagReader reader(source);
  while (const auto tag = reader.next()) {
    if (tag->name == "VTKFile") return tag->attribute("type");
    if (!tag->name.starts_with('?') && !tag->name.starts_with('!')) break;
  }
  return {};
}

bool is_vtk_set(const std::string& xml_type) noexcept { return find_set_type(xml_type) != nullptr; }

const char* format_of_vtk_set(const std::string& xml_type) noexcept {
  return find_set_type(xml_type)->format;
}

VtkSeriesPlace vtk_series_place(const ByteSource& source) {
  XmlTagReader reader(source);
  while (const auto tag = reader.next()) {
    if (tag->name != "Collection") continue;
    VtkSeriesPlace place;
    place.time_unit = plain(tag->attribute("TimeUnit"));
    const std::string word = tag->attribute("Space", name_of(Space::kNone));
    for (const Space space : {Space::kNone, Space::kLps, Space::kRas}) {
      if (word != name_of(space)) continue;
      place.space = space;
      return place;
    }
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: Collection: Space=\"{}\": expected none, LPS or RAS",
                            source.name(), word.substr(0, 40)));
  }
  return {};
}

// The layouts differ in the names of the tags alone.
std::vector<VtkSetFile> vtk_set_files(const ByteSource& source) {
  std::vector<VtkSetFile> files;
  std::vector<std::string> blocks;
  int level = 0;
  XmlTagReader reader(source);
  while (const auto tag = reader.next()) {
    if (tag->name == "/Block" && !blocks.empty()) blocks.pop_back();
    if (tag->name == "AppendedData") break;
    if (tag->name == "Block" && !tag->is_empty_element) {
      level = level_of(source, *tag);
      blocks.push_back(plain(tag->attribute("name", tag->attribute("index"))));
    }
    const bool is_piece = tag->name == "Piece" && tag->attributes.contains("Source");
    const bool is_data_set = tag->name == "DataSet" && tag->attributes.contains("file");
    if (!is_piece && !is_data_set) continue;
    VtkSetFile file;
    const std::string name = plain(tag->attribute(is_piece ? "Source" : "file"));
    if (name.empty()) continue;  // an empty block
    file.path = path_beside(source.name(), name);
    for (const std::string& block : blocks) file.block += block + "/";
    if (is_data_set) file.block += plain(tag->attribute("name", tag->attribute("index")));
    if (is_piece) file.extent = tag->attribute("Extent");
    file.level = level;
    file.time = is_data_set ? time_of(source, *tag) : 0;
    files.push_back(std::move(file));
    if (static_cast<std::int64_t>(files.size()) > kMaxVtkSetFiles) {
      throw Error(ErrorCode::kUnsupported,
                  fmt::format("{}: names more than {} files", source.name(), kMaxVtkSetFiles));
    }
  }
  if (files.empty())
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: names no files", source.name()));
  return files;
}

}  // namespace ovoid::io
