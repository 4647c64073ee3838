// SPDX-License-Identifier: Apache-2.0
// Which grids of a file lie on one lattice.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/foreign/vdb_file.h"
#include "ovoid/io.h"

namespace ovoid::io {

// OpenVDB counts voxels in 32 bits, and the ends of nodes beyond the last must not overflow.
inline constexpr std::int64_t kFarthestVoxel = (std::int64_t{1} << 31) - (std::int64_t{1} << 13);

// A grid of a block: a voxel's indices in it are those in the block and `offset`.
struct VdbMember {
  VdbGrid grid;
  Index3 offset{0, 0, 0};
};

// Grids of numbers whose voxels lie at the same places, or a grid of points.
struct VdbBlock {
  std::string name;  // its first grid's
  bool is_of_points = false;
  Affine3 world_from_index = Affine3::Identity();
  std::vector<VdbMember> members;
};

// All blocks: of lattices in the order of `grids`, then those of points. Grids of which nothing is
// read are in none.
std::vector<VdbBlock> blocks_of(const std::vector<VdbGrid>& grids);

// What options.block and options.array ask for, or else the first: a block with the members that
// are read. None if it is not there.
std::optional<VdbBlock> chosen_block(const std::vector<VdbBlock>& blocks,
                                     const ReadOptions& options);

// By how much the indices of a grid are more than those at the same places of a lattice; none if
// its voxels lie elsewhere.
std::optional<Index3> offset_in(const Affine3& world_from_index, const VdbGrid& grid);

// The lattice of a series, and the box of what is active in it in any step.
struct VdbSeries {
  std::optional<Affine3> world_from_index;  // of the first file that has the chosen block
  VoxelBox box;
};

// Of these files, in which options choose. What a file says is kept for the next call, as long as
// its size and time stay. Boxes are those that the files' metadata say, or, without them, are found
// by reading all voxels. Throws Error.
VdbSeries series_of(const std::vector<std::string>& paths, const ReadOptions& options);

}  // namespace ovoid::io
