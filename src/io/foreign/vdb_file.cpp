// SPDX-License-Identifier: Apache-2.0
#include "io/foreign/vdb_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "io/core/byte_source.h"
#include "io/core/memory.h"
#include "io/vdb/vdb_header.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// OpenVDB's names of its trees of 32^3, 16^3 and 8^3 nodes, which all of its grids are made of.
constexpr std::string_view kPoints = "Tree_ptdataidx32_5_4_3";

std::optional<VdbValues> values_of(std::string_view type) {
  static constexpr std::pair<std::string_view, VdbValues> kKnown[] = {
      {"Tree_float_5_4_3", {ScalarType::kFloat32, 1}},
      {"Tree_double_5_4_3", {ScalarType::kFloat64, 1}},
      {"Tree_int32_5_4_3", {ScalarType::kInt32, 1}},
      {"Tree_int64_5_4_3", {ScalarType::kInt64, 1}},
      {"Tree_bool_5_4_3", {ScalarType::kUInt8, 1}},
      {"Tree_mask_5_4_3", {ScalarType::kUInt8, 1}},
      {"Tree_vec3s_5_4_3", {ScalarType::kFloat32, 3}},
      {"Tree_vec3d_5_4_3", {ScalarType::kFloat64, 3}},
      {"Tree_vec3i_5_4_3", {ScalarType::kInt32, 3}}};
  for (const auto& [name, values] : kKnown)
    if (name == type) return values;
  return std::nullopt;
}

VoxelBox box_of(const openvdb::Coord& first, const openvdb::Coord& last) {
  VoxelBox box;
  for (int a = 0; a < 3; ++a) {
    box.first[static_cast<std::size_t>(a)] = first[a];
    box.last[static_cast<std::size_t>(a)] = last[a];
  }
  return box;
}

VoxelBox told_box(const openvdb::GridBase& grid) {
  using openvdb::GridBase;
  const auto first = grid.getMetadata<openvdb::Vec3IMetadata>(GridBase::META_FILE_BBOX_MIN);
  const auto last = grid.getMetadata<openvdb::Vec3IMetadata>(GridBase::META_FILE_BBOX_MAX);
  if (!first || !last) return {};
  const VoxelBox box = box_of(openvdb::Coord(first->value()), openvdb::Coord(last->value()));
  for (std::size_t a = 0; a < 3; ++a)
    if (box.last[a] < box.first[a]) return {};
  return box;
}

// OpenVDB's matrices take rows: world = index M.
Affine3 affine_of(const openvdb::math::Transform& transform) {
  const openvdb::Mat4d matrix = transform.baseMap()->getAffineMap()->getMat4();
  Affine3 affine = Affine3::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) affine(row, column) = matrix(column, row);
  }
  return affine;
}

// One without a name is called as nameless arrays of other formats are.
std::string name_of_key(const std::string& key) {
  if (key.empty() || key == "[0]") return "values";
  return key.front() == '[' ? "values" + key : key;
}

VdbGrid described(const VdbEntry& entry, const openvdb::GridBase& grid) {
  VdbGrid described;
  described.name = name_of_key(entry.name);
  described.key = entry.name;
  described.type = grid.type();
  described.values = values_of(described.type);
  described.is_of_points = described.type == kPoints;
  described.is_affine = grid.transform().isLinear();
  if (described.is_affine) described.world_from_index = affine_of(grid.transform());
  described.is_level_set = grid.getGridClass() == openvdb::GRID_LEVEL_SET;
  described.is_staggered = grid.getGridClass() == openvdb::GRID_STAGGERED;
  described.told = told_box(grid);
  return described;
}

}  // namespace

void VoxelBox::add(const VoxelBox& other) noexcept {
  if (other.is_empty()) return;
  if (is_empty()) *this = other;
  for (std::size_t a = 0; a < 3; ++a) {
    first[a] = std::min(first[a], other.first[a]);
    last[a] = std::max(last[a], other.last[a]);
  }
}

VoxelBox VoxelBox::moved(const Index3& by) const noexcept {
  VoxelBox box = *this;
  for (std::size_t a = 0; a < 3; ++a) {
    box.first[a] += by[a];
    box.last[a] += by[a];
  }
  return box;
}

Index3 VoxelBox::dims() const noexcept {
  return {last[0] - first[0] + 1, last[1] - first[1] + 1, last[2] - first[2] + 1};
}

VdbFile::VdbFile(std::string source, const std::string& path) : source_(std::move(source)) {
  VdbHeader header = read_vdb_header(*open_file(path));
  for (const VdbEntry& entry : header.grids) {
    std::string_view type = entry.type;
    constexpr std::string_view kHalf = "_HalfFloat";  // how floats are stored, not what they are
    if (type.ends_with(kHalf)) type.remove_suffix(kHalf.size());
    if (openvdb::GridBase::isRegistered(std::string(type))) continue;
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: grid '{}' is of the type {}, which OpenVDB {} does not know: the "
                            "file can be read without that grid alone",
                            source_, entry.name, entry.type, OPENVDB_LIBRARY_VERSION_STRING));
  }
  guarded([&] {
    file_ = std::make_unique<openvdb::io::File>(path);
    file_->open(false);  // else voxels stay in the file, and damaged ones make threads wait forever
    if (!header.has_offsets) {
      for (auto name = file_->beginName(); name != file_->endName(); ++name)
        header.grids.push_back({name.gridName(), ""});
    }
    for (const VdbEntry& entry : header.grids)
      grids_.push_back(described(entry, *file_->readGridMetadata(entry.name)));
  });
  std::stable_partition(grids_.begin(), grids_.end(), [](const VdbGrid& grid) {
    return grid.name == "density" || grid.name == "density[0]";
  });
}

openvdb::GridBase::Ptr VdbFile::read(const VdbGrid& grid) {
  return guarded([&] {
    openvdb::GridBase::Ptr read = file_->readGrid(grid.key);
    if (!read) fail(fmt::format("no grid '{}'", grid.name));
    return read;
  });
}

void VdbFile::fail(const std::string& what) const {
  throw Error(ErrorCode::kFileFormat,
              fmt::format("{}: OpenVDB cannot read it: {}: is the file damaged?", source_, what));
}

void VdbFile::fail_for_memory() const {
  throw Error(ErrorCode::kOutOfMemory,
              fmt::format("{}: OpenVDB asks for more memory than there is: is the file damaged, or "
                          "larger than {:.3g} GiB of voxels?",
                          source_, static_cast<double>(available_memory()) / (1 << 30)));
}

VoxelBox active_box(const openvdb::GridBase& grid) {
  openvdb::CoordBBox box;
  if (!grid.baseTree().evalActiveVoxelBoundingBox(box)) return {};
  return box_of(box.min(), box.max());
}

}  // namespace ovoid::io
