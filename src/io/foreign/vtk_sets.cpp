// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_VTK

#include "io/foreign/vtk_sets.h"

#include <fmt/format.h>
#include <vtkDataSet.h>
#include <vtkImageData.h>

#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "io/foreign/vtk_amr.h"
#include "io/foreign/vtk_header.h"
#include "io/foreign/vtk_image.h"
#include "io/foreign/vtk_leaf.h"
#include "io/foreign/vtk_mesh.h"
#include "io/foreign/vtk_reading.h"
#include "io/foreign/vtk_timed.h"
#include "io/meshes/mesh_blocks.h"
#include "io/meshes/mesh_steps.h"
#include "io/vtk/lattice_pieces.h"
#include "io/vtk/vtk_set_files.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

bool is_xml(const ByteSource& source) { return begins_like_vtk_xml(source.text(0, 512)); }

void check_vtk(const ByteSource& source, const std::string& expected) {
  if (is_xml(source) || begins_like_legacy_vtk(source.text(0, 512))) return;
  throw Error(ErrorCode::kUnsupported,
              fmt::format("{}: is no VTK file: expected {}", source.name(), expected));
}

// A file of a set that is no set itself.
struct LeafFile {
  std::string path;
  std::string block;
};

class SetReader {
 public:
  explicit SetReader(const ReadOptions& options) : options_(options) {
    options_.array.clear();  // not every piece may have it
    options_.progress = {};
  }

  // Adds a file, or the files it names.
  void add(const std::string& path, const std::string& block, int depth) {
    if (depth > kMaxVtkSetDepth) {
      throw Error(ErrorCode::kUnsupported,
                  fmt::format("{}: sets within sets more than {} deep", path, kMaxVtkSetDepth));
    }
    count_file(path);
    const auto source = open_file(path);
    const std::string type = is_xml(*source) ? vtk_xml_type(*source) : "";
    if (is_vtk_set(type)) {
      for (const VtkSetFile& file : vtk_set_files(*source)) {
        const std::string joined =
            block.empty() || file.block.empty() ? block + file.block : block + "/" + file.block;
        add(file.path, joined, depth + 1);
      }
      return;
    }
    leaves_.push_back({path, block});
  }

  // The mesh of all that were added, or the share of it.
  Dataset mesh(Dataset dataset, const ReadOptions& options) {
    const auto part = [&](std::size_t i) {
      const auto source = open_file(leaves_[i].path);
      const VtkLeaf leaf = read(*source);
      MeshPart one = part_of(leaves_[i].path, leaf.data, notes_);
      one.block = leaves_[i].block;
      return one;
    };
    if (options.share) {
      if (const auto known = outlines(); known && are_chosen_by_headers(*known, options)) {
        Dataset share = mesh_share_of_parts(std::move(dataset), *known, part, options);
        share.notes.insert(share.notes.begin(), notes_.begin(), notes_.end());
        return share;
      }
    }
    std::vector<MeshPart> parts;
    for (std::size_t i = 0; i < leaves_.size(); ++i) parts.push_back(part(i));
    dataset.notes = notes_;
    return mesh_of_parts(std::move(dataset), std::move(parts), options);
  }

  const std::vector<std::string>& notes() const noexcept { return notes_; }

  // The file, if it is all that was added and its samples may be a lattice's; else empty.
  std::string only_grid() const {
    if (leaves_.size() != 1) return {};
    const auto source = open_file(leaves_.front().path);
    const std::string type = is_xml(*source) ? vtk_xml_type(*source) : "";
    return type == "ImageData" || type == "RectilinearGrid" ? leaves_.front().path : "";
  }

  AmrGrid grid(const VtkSetFile& file) {
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
  // Of meshes that are shared out by parts: several files whose headers tell all that is decided of
  // them together, and that are no points with a vertex each.
  std::optional<std::vector<PartOutline>> outlines() const {
    if (leaves_.size() < 2) return std::nullopt;
    std::vector<PartOutline> all;
    bool are_meshes = false;
    for (const LeafFile& leaf : leaves_) {
      const auto source = open_file(leaf.path);
      if (!is_xml(*source)) return std::nullopt;
      VtkOutline known = outline_of_vtk_xml_leaf(*source);
      const bool is_grid =
          known.grid == VtkGrid::kUnstructured || known.grid == VtkGrid::kStructured;
      if (!is_grid || !known.is_plain) return std::nullopt;
      std::erase_if(known.arrays, [](const DataArray& array) { return array.name == kGhostArray; });
      if (known.num_cells > 1 && known.num_cells != known.num_points) are_meshes = true;
      all.push_back({leaf.block, known.num_points, known.num_cells, std::move(known.arrays)});
    }
    return are_meshes ? std::optional(std::move(all)) : std::nullopt;
  }

  VtkLeaf read(const ByteSource& source) {
    check_vtk(source, "a piece or block");
    VtkRun run(source, options_);
    VtkLeaf leaf = read_vtk_leaf(source, is_xml(source), options_, run);
    notes_.insert(notes_.end(), run.notes.begin(), run.notes.end());
    return leaf;
  }

  // A set may name itself, or the same set many times.
  void count_file(const std::string& path) {
    if (++num_files_ <= kMaxVtkSetFiles) return;
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: more than {} files in sets within sets", path, kMaxVtkSetFiles));
  }

  ReadOptions options_;
  std::vector<std::string> notes_;
  std::vector<LeafFile> leaves_;
  std::int64_t num_files_ = 0;
};

Dataset begin_dataset(const ByteSource& source, const std::string& xml_type) {
  Dataset dataset;
  dataset.source = source.name();
  dataset.format = format_of_vtk_set(xml_type);
  return dataset;
}

Dataset read_amr(const ByteSource& source, Dataset dataset, const ReadOptions& options) {
  SetReader reader(options);
  std::vector<AmrGrid> grids;
  for (const VtkSetFile& file : vtk_set_files(source)) grids.push_back(reader.grid(file));
  dataset.notes = reader.notes();
  return boxes_of_grids(std::move(dataset), grids, options);
}

// Images and rectilinear grids in pieces; nothing where these are no lattice together.
std::optional<Dataset> read_lattice_pieces(const ByteSource& source, const std::string& xml_type,
                                           const ReadOptions& options) {
  LatticeAssembly assembly(source.name(), lattice_in_pieces(source));
  const std::size_t count = assembly.pieces().size();
  ReadOptions own = options;
  own.progress = {};
  for (std::size_t i = 0; i < count; ++i) {
    const auto file = open_file(assembly.pieces()[i].path);
    check_vtk(*file, "a piece of " + source.name());
    if (is_vtk_set(vtk_xml_type(*file))) return std::nullopt;
    VtkRun run(*file, own);
    const VtkLeaf leaf = read_vtk_leaf(*file, is_xml(*file), own, run);
    Dataset piece;
    piece.source = file->name();
    piece.notes = run.notes;
    ReadOptions all;  // that were read: those that are wanted, and ghosts
    if (!assembly.add(i, dataset_of(*file, leaf.data, std::move(piece), all))) return std::nullopt;
    if (options.progress) options.progress(static_cast<double>(i + 1) / static_cast<double>(count));
  }
  return assembly.finish(begin_dataset(source, xml_type));
}

// Files of the same time are parts of one data set.
Dataset read_series(const ByteSource& source, const ReadOptions& options) {
  std::map<double, std::vector<VtkSetFile>> steps;
  for (VtkSetFile& file : vtk_set_files(source)) steps[file.time].push_back(std::move(file));
  std::vector<double> times;
  times.reserve(steps.size());
  for (const auto& [time, files] : steps) times.push_back(time);
  Dataset dataset = read_mesh_step(
      source.name(), static_cast<std::int64_t>(times.size()), times, options,
      [&](std::int64_t step) {
        const auto& files = steps.at(times[static_cast<std::size_t>(step)]);
        ReadOptions own = options;
        // Which step is shown is found out by looking at all of it.
        if (!options.step) own.share.reset();
        if (files.size() > 1) {
          SetReader reader(own);
          for (const VtkSetFile& file : files) reader.add(file.path, "", 1);
          return reader.mesh(begin_dataset(source, "Collection"), own);
        }
        own.step.reset();
        const auto file = open_file(files.front().path);
        check_vtk(*file, "a step of " + source.name());
        if (is_xml(*file) && vtk_xml_type(*file) == "Collection") {
          throw Error(ErrorCode::kUnsupported,
                      fmt::format("{}: a time series within a time series", file->name()));
        }
        return read_vtk(*file, own);
      });
  const VtkSeriesPlace place = vtk_series_place(source);
  dataset.time_unit = place.time_unit;
  dataset.space = place.space;
  return dataset;
}

Dataset read_vtk_set(const ByteSource& source, const std::string& xml_type,
                     const ReadOptions& options) {
  if (xml_type == "Collection") return read_series(source, options);
  Dataset dataset = begin_dataset(source, xml_type);
  if (dataset.format == "VTK AMR") return read_amr(source, std::move(dataset), options);
  if (xml_type == "PImageData" || xml_type == "PRectilinearGrid") {
    if (auto lattice = read_lattice_pieces(source, xml_type, options)) return std::move(*lattice);
  }
  SetReader reader(options);
  reader.add(source.name(), "", 1);
  if (const std::string path = reader.only_grid(); !path.empty()) {
    Dataset grid = read_vtk_file(*open_file(path), true, options);
    grid.format = dataset.format;
    return grid;
  }
  return reader.mesh(std::move(dataset), options);
}

}  // namespace

Dataset read_vtk(const ByteSource& source, const ReadOptions& options) {
  const std::string type = is_xml(source) ? vtk_xml_type(source) : "";
  if (is_vtk_set(type)) return read_vtk_set(source, type, options);
  return read_vtk_file(source, is_xml(source), options);
}

}  // namespace ovoid::io

#endif
