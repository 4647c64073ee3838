// SPDX-License-Identifier: Apache-2.0
// VTKHDF [VTKHDF], versions 1 and 2, without VTK, whose reader of version 9.1 knows images and
// unstructured grids of one step alone.
#ifdef OVOID_IO_HDF5
#include "io/foreign/vtkhdf.h"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/core/samples.h"
#include "io/foreign/hdf5_attributes.h"
#include "io/foreign/hdf5_handle.h"
#include "io/foreign/vtkhdf_arrays.h"
#include "io/meshes/mesh_steps.h"
#include "io/vtk/image_ghosts.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr int kDeepestAssembly = 16;
constexpr std::size_t kMostBlocks = 100'000;

bool is_composite_vtkhdf(const std::string& type) {
  return type == "PartitionedDataSetCollection" || type == "MultiBlockDataSet";
}

bool is_read_vtkhdf(const std::string& type) {
  return type == "UnstructuredGrid" || type == "PolyData" || type == "ImageData" ||
         type == "OverlappingAMR";
}

// One of the data sets that a file holds.
struct VtkHdfBlock {
  std::string name;  // "" for the only one
  std::string type;
  VtkHdfGroup group;
  VtkHdfSteps steps;
};

class VtkHdfReader {
 public:
  VtkHdfReader(const ByteSource& source, const ReadOptions& options)
      : source_(source), options_(options), objects_(source.name(), source) {}

  Dataset run() {
    file_ = {H5Fopen(source_.name().c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose};
    if (!file_.is_open()) objects_.fail("the HDF5 library cannot open it: is the file truncated?");
    const VtkHdfGroup root(arrays_, objects_.open(file_.get(), "VTKHDF", "/VTKHDF", H5O_TYPE_GROUP),
                           "/VTKHDF");
    check_version(root);
    find_blocks(root);
    const VtkHdfSteps* series = &blocks_.front().steps;
    for (const VtkHdfBlock& block : blocks_) {
      if (block.steps.count() == 1) continue;
      if (series->count() > 1 && series->count() != block.steps.count())
        objects_.fail(fmt::format("block '{}' has {} steps, another {}", block.name,
                                  block.steps.count(), series->count()));
      if (series->count() == 1) series = &block.steps;
    }
    return read_mesh_step(source_.name(), series->count(), series->times(), options_,
                          [&](std::int64_t step) { return read_step(root, step); });
  }

 private:
  void check_version(const VtkHdfGroup& root) {
    const std::vector<double> version = hdf5_numbers(root.id(), "Version", 2);
    if (!version.empty() && version[0] > 2)
      notes_.push_back(
          fmt::format("{}: is of version {:g}, later than 2, by whose rules it is read",
                      source_.name(), version[0]));
  }

  void find_blocks(const VtkHdfGroup& root) {
    std::string type = root.text("Type");
    // As VTK's first reader of the format did, which knew two kinds.
    if (!has_hdf5_attribute(root.id(), "Type"))
      type = has_hdf5_attribute(root.id(), "WholeExtent") ? "ImageData" : "UnstructuredGrid";
    if (!is_composite_vtkhdf(type)) {
      if (!is_read_vtkhdf(type))
        objects_.fail(fmt::format("'/VTKHDF' has the Type '{}', which is not read: expected "
                                  "UnstructuredGrid, PolyData, ImageData, OverlappingAMR, "
                                  "PartitionedDataSetCollection or MultiBlockDataSet",
                                  type),
                      ErrorCode::kUnsupported);
      add_block("", type, root);
      return;
    }
    std::map<std::string, std::string> names;  // of blocks by their groups' names
    if (const auto assembly = root.group("Assembly")) add_names(*assembly, "", 0, names);
    for (const VtkHdfGroup::Member& member : root.members()) {
      if (member.name == "Assembly") continue;
      if (member.link != H5L_TYPE_HARD) {
        leave_out(member.name, "lies in another file, or elsewhere in this one, which is not read");
        continue;
      }
      if (member.type != H5O_TYPE_GROUP) continue;
      auto group = root.group(member.name);
      const std::string own = group->text("Type");
      if (own.empty()) continue;  // an empty block
      const auto name = names.find(member.name);
      if (is_read_vtkhdf(own))
        add_block(name == names.end() ? member.name : name->second, own, std::move(*group));
      else
        leave_out(member.name, fmt::format("is of the Type '{}', which is not read", own));
    }
    if (blocks_.empty())
      objects_.fail(notes_.empty() ? "has no blocks with data"
                                   : fmt::format("has no block that is read: {}", notes_.front()),
                    ErrorCode::kUnsupported);
  }

  void add_block(const std::string& name, const std::string& type, VtkHdfGroup group) {
    VtkHdfSteps steps(group);
    blocks_.push_back({name, type, std::move(group), std::move(steps)});
  }

  void leave_out(const std::string& block, const std::string& why) {
    notes_.push_back(
        fmt::format("{}: block '{}' is left out: it {}", source_.name(), block.substr(0, 80), why));
  }

  // The groups of an assembly hold soft links to blocks: "/VTKHDF/NAME".
  void add_names(const VtkHdfGroup& group, const std::string& path, int depth,
                 std::map<std::string, std::string>& names) const {
    if (depth == kDeepestAssembly) return;
    for (const VtkHdfGroup::Member& member : group.members()) {
      if (names.size() > kMostBlocks) return;
      const std::string name = path.empty() ? member.name : path + '/' + member.name;
      if (member.type == H5O_TYPE_GROUP)
        add_names(*group.group(member.name), name, depth + 1, names);
      if (member.link != H5L_TYPE_SOFT) continue;
      H5L_info_t info{};
      constexpr std::size_t kLongest = 4096;
      if (H5Lget_info(group.id(), member.name.c_str(), &info, H5P_DEFAULT) < 0 ||
          info.u.val_size > kLongest)
        continue;
      std::string target(info.u.val_size, '\0');
      if (H5Lget_val(group.id(), member.name.c_str(), target.data(), target.size(), H5P_DEFAULT) <
          0)
        continue;
      target.resize(std::min(target.size(), target.find('\0')));
      names.try_emplace(target.substr(target.rfind('/') + 1), name);
    }
  }

  Dataset read_step(const VtkHdfGroup& root, std::int64_t step) {
    Dataset dataset;
    dataset.source = source_.name();
    dataset.format = "VTKHDF";
    dataset.notes = notes_;
    ReadProgress progress(options_, 0);
    VtkHdfRead read{step, options_.array, &progress, &dataset.notes};
    VtkHdfContent content;
    for (const VtkHdfBlock& block : blocks_) {
      read.step = block.steps.count() > 1 ? step : 0;
      read_block(block, read, content);
    }
    if (blocks_.front().steps.is_static()) set_time(root, progress, dataset);
    dataset = dataset_of(std::move(dataset), std::move(content));
    if (dataset.kind == DatasetKind::kLattice) hide_ghosts(dataset);
    return dataset;
  }

  static void read_block(const VtkHdfBlock& block, const VtkHdfRead& read, VtkHdfContent& content) {
    if (block.type == "ImageData") {
      content.lattices.push_back(read_vtkhdf_image(block.group, block.steps, read));
      content.lattices.back().block = block.name;
    } else if (block.type == "OverlappingAMR") {
      for (AmrGrid& grid : read_vtkhdf_amr(block.group, block.steps, read))
        content.grids.push_back(std::move(grid));
    } else {
      for (MeshPart& part :
           read_vtkhdf_mesh(block.group, block.type == "PolyData", block.steps, read)) {
        part.block = block.name;
        content.meshes.push_back(std::move(part));
      }
    }
  }

  Dataset dataset_of(Dataset dataset, VtkHdfContent content) const {
    if (!content.grids.empty()) {
      if (!content.lattices.empty() || !content.meshes.empty())
        objects_.fail("holds adaptive grids and other data in blocks, which are not put together",
                      ErrorCode::kUnsupported);
      return boxes_of_grids(std::move(dataset), content.grids, options_);
    }
    if (content.meshes.empty() && content.lattices.size() == 1)
      return lattice_of(std::move(dataset), std::move(content.lattices.front()));
    if (content.meshes.empty())
      return dataset_of_lattices(std::move(dataset), std::move(content.lattices), options_);
    for (LatticePart& lattice : content.lattices)
      content.meshes.push_back(mesh_part_of(std::move(lattice)));
    return mesh_of_parts(std::move(dataset), std::move(content.meshes), options_);
  }

  Dataset lattice_of(Dataset dataset, LatticePart part) const {
    dataset.kind = DatasetKind::kLattice;
    dataset.lattice = std::move(part.lattice);
    dataset.arrays = std::move(part.arrays);
    if (dataset.arrays.empty()) objects_.fail("has no array of numbers");
    if (!options_.array.empty()) static_cast<void>(dataset.array(options_.array));
    shorten_notes(dataset.notes);
    return dataset;
  }

  // A file of one time may say it as VTK's other formats do.
  static void set_time(const VtkHdfGroup& root, ReadProgress& progress, Dataset& dataset) {
    const auto fields = root.group("FieldData");
    if (!fields || !fields->has("TimeValue")) return;
    try {
      const DataArray time = fields->needed("TimeValue").rows(0, 1, progress);
      if (time.num_components == 1 && time.type == ScalarType::kFloat64) {
        double value = 0;
        std::memcpy(&value, time.bytes.view.data(), sizeof(value));
        dataset.times.push_back(value);
      }
    } catch (const Error& problem) {
      if (problem.code() == ErrorCode::kCancelled) throw;
      // Without a time it is read as well.
    }
  }

  const ByteSource& source_;
  const ReadOptions& options_;
  Hdf5Silence silence_;
  Hdf5Objects objects_;
  Hdf5Handle file_;
  VtkHdfFile arrays_{objects_};
  std::vector<VtkHdfBlock> blocks_;
  std::vector<std::string> notes_;
};

}  // namespace

Dataset read_vtk_hdf(const ByteSource& source, const ReadOptions& options) {
  return VtkHdfReader(source, options).run();
}

}  // namespace ovoid::io
#endif
