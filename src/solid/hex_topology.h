// SPDX-License-Identifier: Apache-2.0
// What of a mesh of hexahedra meets what: the edges and faces of its cells, each once, and which of
// them lie around a vertex, an edge or a face.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "ovoid/solid.h"

namespace ovoid::solid {

using CellVertices = std::array<std::uint32_t, 8>;

// A cell's corners are numbered by bits: bit a is the place along axis a.
inline constexpr int kCellCorners = 8, kCellEdges = 12, kCellFaces = 6;

// Local edge `axis * 4 + k` goes along `axis` from this corner to the one with that bit set; bit 0
// of k is the place along the next axis, bit 1 along the one after.
constexpr int first_corner_of_edge(int edge) noexcept {
  const int axis = edge / 4, k = edge % 4;
  return (k & 1) << (axis + 1) % 3 | (k >> 1) << (axis + 2) % 3;
}
// The edge along `axis` that has a corner.
constexpr int edge_at_corner(int axis, int corner) noexcept {
  return axis * 4 + (corner >> (axis + 1) % 3 & 1) + 2 * (corner >> (axis + 2) % 3 & 1);
}
// Local face `axis * 2 + side`: its four corners, one after the other around it.
constexpr std::array<int, 4> corners_of_face(int face) noexcept {
  const int axis = face / 2, base = (face & 1) << axis;
  const int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3;
  return {base, base | u, base | u | v, base | v};
}
constexpr int opposite_face(int face) noexcept { return face ^ 1; }

// Lists of one kind of thing for each of another, in one piece.
class Incidence {
 public:
  // `pairs`: (of which, what); lists keep their order.
  Incidence() = default;
  Incidence(std::size_t count, std::span<const std::array<std::uint32_t, 2>> pairs);
  std::span<const std::uint32_t> of(std::size_t i) const noexcept {
    return std::span(items_).subspan(starts_[i], starts_[i + 1] - starts_[i]);
  }

 private:
  std::vector<std::size_t> starts_;
  std::vector<std::uint32_t> items_;
};

struct HexTopology {
  std::vector<std::array<std::uint32_t, 2>> edges;  // vertices, rising
  // Vertices around a face, and its edges: edge i joins corners i and i + 1, and lies opposite edge
  // i + 2.
  std::vector<std::array<std::uint32_t, 4>> faces, face_edges;
  std::vector<std::array<std::uint32_t, kCellEdges>> cell_edges;
  std::vector<std::array<std::uint32_t, kCellFaces>> cell_faces;
  Incidence cells_of_vertex, cells_of_edge, cells_of_face;
};

// Edge i joins corners i and i + 1 of corners_of_face().
std::array<std::uint32_t, 4> edges_of_face(const HexTopology& topology, std::size_t cell, int face);

// Vertices of the cells are under `num_vertices`, and no two of a cell are the same. Throws
// Error(kOutOfMemory) for more than a twelfth of 2^32 cells.
HexTopology make_topology(std::size_t num_vertices, std::span<const CellVertices> cells);

// The same of a mesh about which nothing is known. Throws what check_solid_mesh() throws but for
// the turn of the corners, which may go astray where cells of a level are very uneven.
HexTopology checked_topology(const SolidMesh& mesh);

}  // namespace ovoid::solid
