// SPDX-License-Identifier: Apache-2.0
// What lies around a vertex or an edge of a mesh of hexahedra, and where a line that comes in along
// one of these things goes on.
#pragma once

#include <cstdint>
#include <vector>

#include "solid/hex_topology.h"

namespace ovoid::solid {

// Of a vertex: the vertices at the other ends of its edges, two of which are next to each other
// where a face has both. Of an edge: its faces, next to each other where a cell has both.
struct Link {
  std::vector<std::uint32_t> things;
  std::vector<std::vector<int>> next;   // [things] positions in `things`, each once
  bool is_closed = false;               // cells on all sides: nothing of the boundary is here
  std::vector<std::vector<int>> rings;  // things around an axis, one after the other
};

Link link_of_vertex(const HexTopology& topology, std::span<const CellVertices> cells,
                    std::uint32_t vertex);
Link link_of_edge(const HexTopology& topology, std::uint32_t edge);

// The weights, for all things of a link, of the place where a line that comes in along thing
// `from` arrives when it goes on through the middle. They add up to 1. Empty: the mesh ends there.
std::vector<double> straight_on(const Link& link, std::size_t from);

// The same on a ring of `count`, at position `steps` from where the line comes in: exact for
// quadratic functions on a regular star, and 1 for what lies opposite in a ring of four.
double ring_weight(std::size_t count, std::size_t steps) noexcept;

}  // namespace ovoid::solid
