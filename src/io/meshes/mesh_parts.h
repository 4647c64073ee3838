// SPDX-License-Identifier: Apache-2.0
// What the readers of meshes share, whatever read the file: a mesh as it comes out of one file or
// block, the checks that everything from a file goes through, and the merging of several into one
// dataset.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// One mesh, or one piece or block of one. `cells.is_structured()` or explicit, as Cells says.
struct MeshPart {
  std::string source;  // the file, for messages; empty: the dataset's
  std::string block;   // what ReadOptions::block calls it; pieces of one block share it
  DataArray positions;
  Cells cells;
  std::vector<DataArray> arrays;  // a tuple per node, or per cell
  bool is_surface = false;        // polygons and lines, which fill no volume: its nodes are points
  std::optional<double> time;

  std::int64_t num_nodes() const noexcept { return positions.num_tuples; }
};

// The bytes of a vector, kept by it.
template <typename T>
Bytes bytes_owning(std::vector<T> values) {
  const auto owner = std::make_shared<std::vector<T>>(std::move(values));
  return {owner, std::as_bytes(std::span<const T>(*owner))};
}

// What a file claims is put right or refused here. Throws Error(kFileFormat) naming `where` unless
// there are nodes, positions are [n, 3] floats, offsets rise from 0 to the size of connectivity,
// every node number is below the number of nodes, structured dims give the number of nodes, cell
// types have the nodes they need, and every array has a tuple per node or cell. kUnsupported for
// 2^32 nodes and more.
void check_mesh(const std::string& where, const MeshPart& part);

// The nodes a cell of this type needs; 0 if it may have any number.
int num_corners(CellType type) noexcept;

// What drop_ghosts() looks for. The older one says how far within another's part a cell is.
inline constexpr const char* kGhostArray = "vtkGhostType";
inline constexpr const char* kOldGhostArray = "vtkGhostLevels";

// VTK's bits in arrays called kGhostArray [VTK 2021]; those of points, and of cells.
inline constexpr unsigned kDuplicatePoint = 1;
inline constexpr unsigned kHiddenPoint = 2;
inline constexpr unsigned kDuplicateCell = 1;
inline constexpr unsigned kRefinedCell = 8;
inline constexpr unsigned kHiddenCell = 32;
inline constexpr unsigned kUnseenCell = kDuplicateCell | kRefinedCell | kHiddenCell;

// Has it one of these names?
bool is_ghost_array(const DataArray& array) noexcept;

// Nothing but vertices, or nothing between its nodes.
bool is_point_set(const MeshPart& part);

// Structured cells become hexahedra, quads, lines or a vertex, by the axes longer than one node.
void make_explicit(MeshPart& part);

// Honours ghost arrays, where `part` has them: cells that are duplicates of another
// piece's, hidden or refined are taken out with their tuples, and so are cells with a hidden node
// and cells without nodes; of a part without cells, the points that are hidden or duplicates. The
// arrays themselves are dropped. Returns how many cells or points went.
std::int64_t drop_ghosts(MeshPart& part);

// Makes the dataset of all parts: kMesh, or kParticles if there are no cells but vertices. Empty
// parts are passed over; the others go through check_mesh and drop_ghosts. `dataset` has source,
// format and notes. Which blocks are read, choose_blocks() says. Nodes of different parts at
// exactly the same place become one. Of a mesh options.array alone is kept, of particles all
// arrays; a mesh without arrays gets zeros at its nodes, called "nothing". Throws
// Error(kInvalidArgument) for an unknown block or array, Error(kFileFormat) if nothing is left.
Dataset mesh_of_parts(Dataset dataset, std::vector<MeshPart> parts, const ReadOptions& options);

}  // namespace ovoid::io
