// SPDX-License-Identifier: Apache-2.0
// The nodes and cells of a mesh, checked, as the mesh kernels see them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "model/mesh/cell_tables.h"
#include "model/particles/kernel_parts.h"

namespace ovoid::model {

// Nodes with their places. Nodes at exactly one place are one node: the first of them.
struct MeshNodes {
  std::vector<double> positions;              // [n, 3], of all, finite or not
  std::vector<std::uint32_t> representative;  // [n]; empty: every node its own
  std::int64_t num_merged = 0;

  std::size_t count() const noexcept { return positions.size() / 3; }
  std::uint32_t stands_for(std::uint32_t node) const noexcept {
    return representative.empty() ? node : representative[node];
  }
  Vec3 at(std::uint32_t node) const noexcept {
    const double* p = positions.data() + std::size_t{3} * node;
    return {p[0], p[1], p[2]};
  }
  bool is_placed(std::uint32_t node) const noexcept { return at(node).allFinite(); }
};

// Nodes at places [n, 3].
MeshNodes merged_nodes(std::vector<double> places);
MeshNodes load_nodes(const ModelRun& run);

// Of maps by place: equal places give equal hashes; -0 and 0 are one place.
struct PlaceHash {
  std::size_t operator()(const Vec3& place) const noexcept;
};

// Cells as lists of nodes; the cells of a structured grid are written out.
struct MeshCells {
  std::span<const CellType> types;
  std::span<const std::int64_t> offsets;
  std::span<const std::uint32_t> connectivity;
  std::vector<CellType> own_types;  // behind the spans, where they are not the dataset's
  std::vector<std::int64_t> own_offsets;
  std::vector<std::uint32_t> own_connectivity;

  std::size_t count() const noexcept { return types.size(); }
  std::span<const std::uint32_t> nodes(std::size_t cell) const noexcept {
    const auto begin = static_cast<std::size_t>(offsets[cell]);
    return connectivity.subspan(begin, static_cast<std::size_t>(offsets[cell + 1]) - begin);
  }
};

MeshCells cells_owning(std::vector<CellType> types, std::vector<std::int64_t> offsets,
                       std::vector<std::uint32_t> connectivity);

// Throws Error(kInvalidArgument) that names the cell: no cells, lengths that do not agree, nodes
// that do not exist, a cell with another number of nodes than its type has. All of a team call it;
// one of its shares may have no cells.
MeshCells load_cells(const ModelRun& run);

// Mean of a cell's nodes and their covariance about it. A box has corners of covariance edge^2 / 4:
// a kernel with that covariance is the one a lattice's sample would have.
struct CellMoments {
  Vec3 mean = Vec3::Zero();
  Mat3 covariance = Mat3::Zero();
};

CellMoments moments_of(const MeshNodes& nodes, std::span<const std::uint32_t> cell) noexcept;

// What cells say as a whole.
struct CellMeasures {
  // Signed. Of cells of other types a guess from the spread of their nodes; NaN where a node has no
  // place, and the cell is as if it were not there.
  std::vector<double> volumes;
  std::vector<std::uint32_t> others;  // cells of other types, rising
  std::vector<CellMoments> other_moments;

  bool is_placed(std::size_t cell) const noexcept { return volumes[cell] == volumes[cell]; }
  const CellMoments& moments_of_other(std::uint32_t cell) const noexcept;
};

CellMeasures measure_cells(const ModelRun& run, const MeshNodes& nodes, const MeshCells& cells);

}  // namespace ovoid::model
