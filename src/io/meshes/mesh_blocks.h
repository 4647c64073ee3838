// SPDX-License-Identifier: Apache-2.0
// What is read of a set of meshes: all blocks or one, and the arrays that all parts have. It is
// decided by outlines, which headers tell.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "io/meshes/mesh_parts.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// A part without its numbers.
struct PartOutline {
  std::string block;
  std::int64_t num_nodes = 0;
  std::int64_t num_cells = 0;
  std::vector<DataArray> arrays;  // without bytes
  bool has_volume = true;         // some cell encloses one; headers do not tell
};

PartOutline outline_of(const MeshPart& part);

// Two arrays of different parts that may be one.
bool is_same_array(const DataArray& a, const DataArray& b) noexcept;

// Fills dataset.blocks, and block where one is read. Returns the numbers of the parts that are
// read: of options.block; else all, if they share an array; else those of the blocks that have
// arrays and cells of a volume, as node sets have not, or what comes nearest to that: all of these
// if they share an array or have none, else the largest. Throws Error(kInvalidArgument) for an
// unknown block.
std::vector<std::size_t> choose_blocks(Dataset& dataset, std::span<const PartOutline> parts,
                                       const ReadOptions& options);

// Does choose_blocks() need no outline's has_volume?
bool are_chosen_by_headers(std::span<const PartOutline> parts, const ReadOptions& options);

// The arrays that every part has; those that one has not are told. One without cells has no cell
// arrays to have.
std::vector<DataArray> shared_arrays(Dataset& dataset, std::span<const PartOutline> parts);

// mesh_of_parts() of which a process takes options.share: whole parts, in runs with about as many
// cells. `read(p)` is asked for those of the outlines that it takes, which may be none. The dataset
// is a mesh, whatever cells it has; its notes on cells and points are those of its own parts.
// Throws what mesh_of_parts() throws, and Error(kFileFormat) for a part that is not as outlined.
Dataset mesh_share_of_parts(Dataset dataset, std::span<const PartOutline> outlines,
                            const std::function<MeshPart(std::size_t)>& read,
                            const ReadOptions& options);

}  // namespace ovoid::io
