// SPDX-License-Identifier: Apache-2.0
#include "io/vtk_sets.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "ovoid/error.h"

namespace ovoid::io {
namespace {

struct SetType {
  std::string_view type;
  const char* format;
};
constexpr std::array<SetType, 9> kSetTypes{{{"PUnstructuredGrid", "PVTU"},
                                            {"PPolyData", "PVTP"},
                                            {"PStructuredGrid", "PVTS"},
                                            {"PRectilinearGrid", "PVTR"},
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

}  // namespace

bool is_vtk_set(const std::string& xml_type) noexcept { return find_set_type(xml_type) != nullptr; }

}  // namespace ovoid::io

#ifndef OVOID_IO_VTK

namespace ovoid::io {

Dataset read_vtk_set(const ByteSource& source, const std::string& xml_type, const ReadOptions&) {
  throw Error(ErrorCode::kUnsupported,
              fmt::format("{}: this build has no VTK and cannot read {} files", source.name(),
                          find_set_type(xml_type)->format));
}

}  // namespace ovoid::io

#else

#include <vtkDataSet.h>
#include <vtkImageData.h>

#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include "io/formats.h"
#include "io/mesh_steps.h"
#include "io/read_source.h"
#include "io/vtk_amr.h"
#include "io/vtk_leaf.h"
#include "io/vtk_mesh.h"
#include "io/xml_tags.h"

namespace ovoid::io {
namespace {

constexpr int kMaxDepth = 8;
constexpr std::int64_t kMaxFiles = 10000;

// A file that a set names.
struct NamedFile {
  std::string path;
  std::string block;  // the names of the blocks around it
  int level = 0;      // adaptive grids
  double time = 0;    // time series
};

double time_of(const ByteSource& source, const XmlTag& tag) {
  const std::string text = tag.attribute("timestep", "0");
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: DataSet: timestep=\"{}\": expected a finite number", source.name(),
                            text.substr(0, 40)));
  }
  return value;
}

int level_of(const ByteSource& source, const XmlTag& tag) {
  const std::string text = tag.attribute("level", "0");
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < 0 || value > 1000) {
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: Block: level=\"{}\": expected 0 to 1000",
                                                    source.name(), text.substr(0, 40)));
  }
  return value;
}

// The files of a set, in the order they stand. The layouts differ in the names of the tags alone.
std::vector<NamedFile> named_files(const ByteSource& source) {
  std::vector<NamedFile> files;
  std::vector<std::string> blocks;
  int level = 0;
  XmlTagReader reader(source);
  while (const auto tag = reader.next()) {
    if (tag->name == "/Block" && !blocks.empty()) blocks.pop_back();
    if (tag->name == "AppendedData") break;
    if (tag->name == "Block" && !tag->is_empty_element) {
      level = level_of(source, *tag);
      blocks.push_back(tag->attribute("name", tag->attribute("index")));
    }
    const bool is_piece = tag->name == "Piece" && tag->attributes.contains("Source");
    const bool is_data_set = tag->name == "DataSet" && tag->attributes.contains("file");
    if (!is_piece && !is_data_set) continue;
    NamedFile file;
    const std::string name = tag->attribute(is_piece ? "Source" : "file");
    if (name.empty()) continue;  // an empty block
    file.path = path_beside(source.name(), name);
    for (const std::string& block : blocks) file.block += block + "/";
    if (is_data_set) file.block += tag->attribute("name", tag->attribute("index"));
    file.level = level;
    file.time = is_data_set ? time_of(source, *tag) : 0;
    files.push_back(std::move(file));
    if (static_cast<std::int64_t>(files.size()) > kMaxFiles) {
      throw Error(ErrorCode::kUnsupported,
                  fmt::format("{}: names more than {} files", source.name(), kMaxFiles));
    }
  }
  if (files.empty())
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: names no files", source.name()));
  return files;
}

class SetReader {
 public:
  SetReader(const ReadOptions& options, std::vector<std::string>& notes)
      : options_(options), notes_(notes) {
    options_.array.clear();  // not every piece may have it
    options_.progress = {};
  }

  std::vector<MeshPart> parts;

  // Adds the parts of a file, or of the files it names.
  void add(const std::string& path, const std::string& block, int depth) {
    if (depth > kMaxDepth) {
      throw Error(ErrorCode::kUnsupported,
                  fmt::format("{}: sets within sets more than {} deep", path, kMaxDepth));
    }
    count_file(path);
    const auto source = open_file(path);
    const bool is_xml = kind_of(source->text(0, 512)) == FileKind::kVtkXml;
    const std::string type = is_xml ? vtk_xml_type(*source) : "";
    if (is_vtk_set(type)) {
      for (const NamedFile& file : named_files(*source)) {
        const std::string joined =
            block.empty() || file.block.empty() ? block + file.block : block + "/" + file.block;
        add(file.path, type == "vtkMultiBlockDataSet" ? joined : block, depth + 1);
      }
      return;
    }
    const VtkLeaf leaf = read(*source);
    parts.push_back(part_of(path, leaf.data, notes_));
    parts.back().block = block;
  }

  AmrGrid grid(const NamedFile& file) {
    count_file(file.path);
    const auto source = open_file(file.path);
    const VtkLeaf leaf = read(*source);
    auto* const image = vtkImageData::SafeDownCast(leaf.data);
    if (image == nullptr) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: expected ImageData, as adaptive grids are made of", file.path));
    }
    return amr_grid_of(file.path, image, file.level, notes_);
  }

 private:
  VtkLeaf read(const ByteSource& source) {
    const FileKind kind = kind_of(source.text(0, 512));
    if (kind != FileKind::kVtkXml && kind != FileKind::kVtkLegacy) {
      throw Error(ErrorCode::kUnsupported,
                  fmt::format("{}: is no VTK file: expected a piece or block", source.name()));
    }
    VtkRun run(source, options_);
    VtkLeaf leaf = read_vtk_leaf(source, kind == FileKind::kVtkXml, options_, run);
    notes_.insert(notes_.end(), run.notes.begin(), run.notes.end());
    return leaf;
  }

  // A set may name itself, or the same set many times.
  void count_file(const std::string& path) {
    if (++num_files_ <= kMaxFiles) return;
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: more than {} files in sets within sets", path, kMaxFiles));
  }

  ReadOptions options_;
  std::vector<std::string>& notes_;
  std::int64_t num_files_ = 0;
};

Dataset begin_dataset(const ByteSource& source, const std::string& xml_type) {
  Dataset dataset;
  dataset.source = source.name();
  dataset.format = find_set_type(xml_type)->format;
  return dataset;
}

Dataset read_amr(const ByteSource& source, Dataset dataset, const ReadOptions& options) {
  SetReader reader(options, dataset.notes);
  std::vector<AmrGrid> grids;
  for (const NamedFile& file : named_files(source)) grids.push_back(reader.grid(file));
  return boxes_of_grids(std::move(dataset), grids, options);
}

// Files of the same time are parts of one data set.
Dataset read_series(const ByteSource& source, const ReadOptions& options) {
  std::map<double, std::vector<NamedFile>> steps;
  for (NamedFile& file : named_files(source)) steps[file.time].push_back(std::move(file));
  std::vector<double> times;
  times.reserve(steps.size());
  for (const auto& [time, files] : steps) times.push_back(time);
  return read_mesh_step(
      source.name(), static_cast<std::int64_t>(times.size()), times, options,
      [&](std::int64_t step) {
        const auto& files = steps.at(times[static_cast<std::size_t>(step)]);
        if (files.size() > 1) {
          Dataset dataset = begin_dataset(source, "Collection");
          SetReader reader(options, dataset.notes);
          for (const NamedFile& file : files) reader.add(file.path, "", 1);
          return mesh_of_parts(std::move(dataset), std::move(reader.parts), options);
        }
        ReadOptions own = options;
        own.step.reset();
        const auto file = open_file(files.front().path);
        if (vtk_xml_type(*file) == "Collection") {
          throw Error(ErrorCode::kUnsupported,
                      fmt::format("{}: a time series within a time series", file->name()));
        }
        return read_source(*file, own);
      });
}

}  // namespace

Dataset read_vtk_set(const ByteSource& source, const std::string& xml_type,
                     const ReadOptions& options) {
  if (xml_type == "Collection") return read_series(source, options);
  Dataset dataset = begin_dataset(source, xml_type);
  if (dataset.format == "VTK AMR") return read_amr(source, std::move(dataset), options);
  SetReader reader(options, dataset.notes);
  reader.add(source.name(), "", 1);
  return mesh_of_parts(std::move(dataset), std::move(reader.parts), options);
}

}  // namespace ovoid::io

#endif
