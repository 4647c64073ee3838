// SPDX-License-Identifier: Apache-2.0
#include "io/foreign/vdb_blocks.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <system_error>
#include <utility>

namespace ovoid::io {
namespace {

namespace fs = std::filesystem;

// How far voxels of two grids may lie apart, in voxels, and be the same; and how much their axes
// may differ.
constexpr double kSamePlace = 1e-3;
constexpr double kSameAxes = 1e-6;

bool is_of_lattice(const VdbGrid& grid) { return grid.values && grid.is_affine; }

class KnownFiles {
 public:
  const std::vector<VdbBlock>& blocks_in(const std::string& path) {
    std::error_code ignored;
    const auto stamp = std::pair(fs::file_size(path, ignored), fs::last_write_time(path, ignored));
    const auto found = known_.find(path);
    if (found != known_.end() && found->second.stamp == stamp) return found->second.blocks;
    VdbFile file(path, path);
    std::vector<VdbGrid> grids = file.grids();
    for (VdbGrid& grid : grids)
      if (is_of_lattice(grid) && grid.told.is_empty()) grid.told = active_box(*file.read(grid));
    return (known_[path] = {stamp, blocks_of(grids)}).blocks;
  }

 private:
  struct Known {
    std::pair<std::uintmax_t, fs::file_time_type> stamp;
    std::vector<VdbBlock> blocks;
  };
  std::map<std::string, Known> known_;
};

}  // namespace

std::optional<Index3> offset_in(const Affine3& world_from_index, const VdbGrid& grid) {
  if (!is_of_lattice(grid)) return std::nullopt;
  const Mat3 axes = world_from_index.linear();
  const double voxel = axes.colwise().norm().minCoeff();
  const Mat3 difference = axes - grid.world_from_index.linear();
  if (!(difference.cwiseAbs().maxCoeff() <= kSameAxes * voxel)) return std::nullopt;
  const Vec3 apart =
      axes.inverse() * (world_from_index.translation() - grid.world_from_index.translation());
  Index3 offset{};
  for (int a = 0; a < 3; ++a) {
    const double whole = std::round(apart[a]);
    const bool is_same = std::abs(apart[a] - whole) <= kSamePlace &&
                         std::abs(whole) <= static_cast<double>(kFarthestVoxel);
    if (!is_same) return std::nullopt;
    offset[static_cast<std::size_t>(a)] = static_cast<std::int64_t>(whole);
  }
  return offset;
}

std::vector<VdbBlock> blocks_of(const std::vector<VdbGrid>& grids) {
  std::vector<VdbBlock> blocks;
  for (const VdbGrid& grid : grids) {
    if (!is_of_lattice(grid)) continue;
    bool is_new = true;
    for (VdbBlock& block : blocks) {
      const auto offset = offset_in(block.world_from_index, grid);
      if (!offset) continue;
      block.members.push_back({grid, *offset});
      is_new = false;
      break;
    }
    if (is_new) blocks.push_back({grid.name, false, grid.world_from_index, {{grid, {}}}});
  }
  for (const VdbGrid& grid : grids)
    if (grid.is_of_points) blocks.push_back({grid.name, true, grid.world_from_index, {{grid, {}}}});
  return blocks;
}

std::optional<VdbBlock> chosen_block(const std::vector<VdbBlock>& blocks,
                                     const ReadOptions& options) {
  for (const VdbBlock& block : blocks) {
    if (!options.block.empty() && block.name != options.block) continue;
    // Of points the name is an attribute's, and all are read.
    if (options.array.empty() || block.is_of_points) return block;
    for (const VdbMember& member : block.members) {
      if (member.grid.name != options.array) continue;
      VdbBlock chosen = block;
      chosen.members = {member};
      return chosen;
    }
  }
  return std::nullopt;
}

VdbSeries series_of(const std::vector<std::string>& paths, const ReadOptions& options) {
  static KnownFiles known;
  VdbSeries series;
  for (const std::string& path : paths) {
    const auto block = chosen_block(known.blocks_in(path), options);
    if (!block || block->is_of_points) continue;
    if (!series.world_from_index) series.world_from_index = block->world_from_index;
    for (const VdbMember& member : block->members) {
      const auto offset = offset_in(*series.world_from_index, member.grid);
      if (!offset) continue;  // another lattice: who compares the steps says so
      series.box.add(member.grid.told.moved({-(*offset)[0], -(*offset)[1], -(*offset)[2]}));
    }
  }
  return series;
}

}  // namespace ovoid::io
