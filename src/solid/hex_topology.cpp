// SPDX-License-Identifier: Apache-2.0
#include "solid/hex_topology.h"

#include <fmt/format.h>

#include <algorithm>
#include <compare>
#include <limits>
#include <numeric>

#include "ovoid/error.h"

namespace ovoid::solid {

namespace {

using Pairs = std::vector<std::array<std::uint32_t, 2>>;

// Gives equal keys one number, in the order of the keys. `keys` become the distinct ones.
template <class Key>
std::vector<std::uint32_t> number_keys(std::vector<Key>& keys) {
  std::vector<std::uint32_t> order(keys.size()), numbers(keys.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return keys[a] != keys[b] ? keys[a] < keys[b] : a < b;
  });
  std::vector<Key> distinct;
  for (const std::uint32_t slot : order) {
    if (distinct.empty() || distinct.back() != keys[slot]) distinct.push_back(keys[slot]);
    numbers[slot] = static_cast<std::uint32_t>(distinct.size() - 1);
  }
  keys = std::move(distinct);
  return numbers;
}

// What is the same for two cells that share an edge, or a face: its vertices, rising.
using EdgeKey = std::uint64_t;
struct FaceKey {
  EdgeKey first = 0, last = 0;
  auto operator<=>(const FaceKey&) const = default;
};

EdgeKey key_of(std::uint32_t lesser, std::uint32_t greater) {
  return std::uint64_t{lesser} << 32 | greater;
}

EdgeKey key_of_edge(std::uint32_t a, std::uint32_t b) {
  return key_of(std::min(a, b), std::max(a, b));
}

FaceKey key_of_face(std::array<std::uint32_t, 4> vertices) {
  std::sort(vertices.begin(), vertices.end());
  return {key_of(vertices[0], vertices[1]), key_of(vertices[2], vertices[3])};
}

std::array<std::uint32_t, 4> vertices_of_face(const CellVertices& cell, int face) {
  std::array<std::uint32_t, 4> vertices{};
  const auto corners = corners_of_face(face);
  for (std::size_t i = 0; i < 4; ++i) vertices[i] = cell[static_cast<std::size_t>(corners[i])];
  return vertices;
}

void number_edges(std::span<const CellVertices> cells, HexTopology& topology) {
  std::vector<EdgeKey> keys;
  keys.reserve(kCellEdges * cells.size());
  for (const CellVertices& cell : cells) {
    for (int e = 0; e < kCellEdges; ++e) {
      const auto corner = static_cast<std::size_t>(first_corner_of_edge(e));
      keys.push_back(key_of_edge(cell[corner], cell[corner | std::size_t{1} << e / 4]));
    }
  }
  const std::vector<std::uint32_t> numbers = number_keys(keys);
  for (const EdgeKey key : keys)
    topology.edges.push_back(
        {static_cast<std::uint32_t>(key >> 32), static_cast<std::uint32_t>(key)});
  topology.cell_edges.resize(cells.size());
  for (std::size_t slot = 0; slot < numbers.size(); ++slot)
    topology.cell_edges[slot / kCellEdges][slot % kCellEdges] = numbers[slot];
}

}  // namespace

std::array<std::uint32_t, 4> edges_of_face(const HexTopology& topology, std::size_t cell,
                                           int face) {
  std::array<std::uint32_t, 4> edges{};
  const auto corners = corners_of_face(face);
  for (std::size_t i = 0; i < 4; ++i) {
    const int turned = corners[i] ^ corners[(i + 1) % 4];  // the one bit in which they differ
    const int axis = turned == 1 ? 0 : turned == 2 ? 1 : 2;
    edges[i] =
        topology.cell_edges[cell][static_cast<std::size_t>(edge_at_corner(axis, corners[i]))];
  }
  return edges;
}

namespace {

void number_faces(std::span<const CellVertices> cells, HexTopology& topology) {
  std::vector<FaceKey> keys;
  keys.reserve(kCellFaces * cells.size());
  for (const CellVertices& cell : cells) {
    for (int f = 0; f < kCellFaces; ++f) keys.push_back(key_of_face(vertices_of_face(cell, f)));
  }
  const std::vector<std::uint32_t> numbers = number_keys(keys);
  topology.faces.resize(keys.size());
  topology.face_edges.resize(keys.size());
  topology.cell_faces.resize(cells.size());
  for (std::size_t slot = numbers.size(); slot-- > 0;) {  // the first cell of a face has the word
    const std::size_t cell = slot / kCellFaces;
    const int local = static_cast<int>(slot % kCellFaces);
    const std::uint32_t face = numbers[slot];
    topology.cell_faces[cell][slot % kCellFaces] = face;
    topology.faces[face] = vertices_of_face(cells[cell], local);
    topology.face_edges[face] = edges_of_face(topology, cell, local);
  }
}

// For each of `count` things the cells that have it.
template <std::size_t N>
Incidence cells_with(std::size_t count, std::span<const std::array<std::uint32_t, N>> of_cell) {
  Pairs pairs;
  pairs.reserve(N * of_cell.size());
  for (std::size_t c = 0; c < of_cell.size(); ++c) {
    for (const std::uint32_t thing : of_cell[c])
      pairs.push_back({thing, static_cast<std::uint32_t>(c)});
  }
  return {count, pairs};
}

}  // namespace

Incidence::Incidence(std::size_t count, std::span<const std::array<std::uint32_t, 2>> pairs)
    : starts_(count + 1), items_(pairs.size()) {
  for (const auto& pair : pairs) ++starts_[pair[0] + 1];
  std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
  std::vector<std::size_t> next(starts_.begin(), starts_.end() - 1);
  for (const auto& pair : pairs) items_[next[pair[0]]++] = pair[1];
}

HexTopology make_topology(std::size_t num_vertices, std::span<const CellVertices> cells) {
  // Edges are first numbered cell by cell.
  constexpr std::size_t kMostCells = std::numeric_limits<std::uint32_t>::max() / kCellEdges;
  if (cells.size() > kMostCells)
    throw Error(ErrorCode::kOutOfMemory,
                fmt::format("cells: {}, must be {} at most", cells.size(), kMostCells));
  HexTopology topology;
  number_edges(cells, topology);
  number_faces(cells, topology);
  topology.cells_of_vertex = cells_with(num_vertices, cells);
  topology.cells_of_edge =
      cells_with(topology.edges.size(),
                 std::span<const std::array<std::uint32_t, kCellEdges>>(topology.cell_edges));
  topology.cells_of_face =
      cells_with(topology.faces.size(),
                 std::span<const std::array<std::uint32_t, kCellFaces>>(topology.cell_faces));
  return topology;
}

}  // namespace ovoid::solid
