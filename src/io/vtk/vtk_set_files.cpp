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
constexpr std::array<SetType, 12> kSetTypes{{{"PUnstructuredGrid", "PVTU"},
                                             {"PPolyData", "PVTP"},
                                             {"PStructuredGrid", "PVTS"},
                                             {"PRectilinearGrid", "PVTR"},
                                             {"PImageData", "PVTI"},
                                             {"vtkMultiBlockDataSet", "VTM"},
                                             {"vtkPartitionedDataSetCollection", "VTPC"},
                                             {"vtkPartitionedDataSet", "VTPD"},
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

namespace {

// An element that others stand in: a block of blocks, or one block of several pieces.
struct Container {
  std::string element;
  std::string name;
  bool has_pieces = false;
};

// Where the files of a set stand, while its tags come.
class SetPlaces {
 public:
  explicit SetPlaces(const ByteSource& source) : source_(source) {}

  // Takes what names no file itself.
  void pass(const XmlTag& tag) {
    if (tag.name == "VTKFile") {
      const std::string type = tag.attribute("type");
      has_blocks_ = type == "vtkMultiBlockDataSet" || type == "vtkPartitionedDataSetCollection";
    }
    if (!containers_.empty() && tag.name == "/" + containers_.back().element)
      containers_.pop_back();
    const bool is_block = tag.name == "Block";
    const bool has_pieces = tag.name == "Partitions" || (tag.name == "Piece" && has_blocks_);
    if (tag.is_empty_element || !(is_block || has_pieces)) return;
    if (is_block) level_ = level_of(source_, tag);
    containers_.push_back({tag.name, name_of_block(tag), has_pieces});
  }

  int level() const noexcept { return level_; }

  // "outer/inner"; empty where the set has no blocks.
  std::string block_of(const XmlTag& file) const {
    if (!has_blocks_) return {};
    std::string block;
    for (const Container& container : containers_)
      block += (block.empty() ? "" : "/") + container.name;
    if (containers_.empty() || !containers_.back().has_pieces)
      block += (block.empty() ? "" : "/") + name_of_block(file);
    return block;
  }

 private:
  static std::string name_of_block(const XmlTag& tag) {
    return plain(tag.attribute("name", tag.attribute("index")));
  }

  const ByteSource& source_;
  std::vector<Container> containers_;
  bool has_blocks_ = false;
  int level_ = 0;
};

}  // namespace

// The layouts differ in the names of the tags alone.
std::vector<VtkSetFile> vtk_set_files(const ByteSource& source) {
  std::vector<VtkSetFile> files;
  SetPlaces places(source);
  XmlTagReader reader(source);
  while (const auto tag = reader.next()) {
    if (tag->name == "AppendedData") break;
    const bool is_piece = tag->name == "Piece" && tag->attributes.contains("Source");
    const bool is_data_set = tag->name == "DataSet" && tag->attributes.contains("file");
    if (!is_piece && !is_data_set) {
      places.pass(*tag);
      continue;
    }
    VtkSetFile file;
    const std::string name = plain(tag->attribute(is_piece ? "Source" : "file"));
    if (name.empty()) continue;  // an empty block
    file.path = path_beside(source.name(), name);
    if (is_data_set) file.block = places.block_of(*tag);
    if (is_piece) file.extent = tag->attribute("Extent");
    file.level = places.level();
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
