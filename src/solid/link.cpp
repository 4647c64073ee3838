// SPDX-License-Identifier: Apache-2.0
#include "solid/link.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace ovoid::solid {

namespace {

using Pair = std::array<int, 2>;

int position_of(Link& link, std::uint32_t thing) {
  const auto found = std::find(link.things.begin(), link.things.end(), thing);
  const auto position = static_cast<int>(found - link.things.begin());
  if (found == link.things.end()) {
    link.things.push_back(thing);
    link.next.emplace_back();
  }
  return position;
}

void join(Link& link, const Pair& pair) {
  for (int side = 0; side < 2; ++side) {
    auto& list = link.next[static_cast<std::size_t>(pair[side])];
    if (std::find(list.begin(), list.end(), pair[1 - side]) == list.end())
      list.push_back(pair[1 - side]);
  }
}

// The things of the pairs in the order of a walk around; empty unless they form one closed ring.
std::vector<int> ring_of(const std::vector<Pair>& pairs) {
  std::vector<int> ring;
  if (pairs.size() < 2) return ring;
  std::vector<bool> is_used(pairs.size());
  ring.push_back(pairs[0][0]);
  int at = pairs[0][1];
  is_used[0] = true;
  while (at != ring[0]) {
    ring.push_back(at);
    std::size_t way = 0;
    while (way < pairs.size() && (is_used[way] || (pairs[way][0] != at && pairs[way][1] != at)))
      ++way;
    if (way == pairs.size()) return {};
    is_used[way] = true;
    at = pairs[way][0] == at ? pairs[way][1] : pairs[way][0];
  }
  if (ring.size() != pairs.size()) return {};
  return ring;
}

std::vector<double> share(std::size_t count, const std::vector<std::size_t>& among) {
  std::vector<double> weights(count);
  for (const std::size_t i : among) weights[i] = 1 / static_cast<double>(among.size());
  return weights;
}

// The first ring that holds a thing, from there on; empty: none.
std::vector<int> ring_from(const Link& link, std::size_t thing) {
  for (std::vector<int> ring : link.rings) {
    const auto found = std::find(ring.begin(), ring.end(), static_cast<int>(thing));
    if (found == ring.end()) continue;
    std::rotate(ring.begin(), found, ring.end());
    return ring;
  }
  return {};
}

}  // namespace

Link link_of_vertex(const HexTopology& topology, std::span<const CellVertices> cells,
                    std::uint32_t vertex) {
  Link link;
  std::vector<std::array<int, 3>> corners;  // what meets in the vertex, of each cell
  for (const std::uint32_t c : topology.cells_of_vertex.of(vertex)) {
    const CellVertices& cell = cells[c];
    const auto corner =
        static_cast<std::size_t>(std::find(cell.begin(), cell.end(), vertex) - cell.begin());
    std::array<int, 3> ends{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      ends[axis] = position_of(link, cell[corner ^ std::size_t{1} << axis]);
    corners.push_back(ends);
    for (std::size_t axis = 0; axis < 3; ++axis) join(link, {ends[axis], ends[(axis + 1) % 3]});
  }
  // A closed surface of triangles has 3/2 edges for each.
  std::size_t num_ends = 0;
  for (const auto& list : link.next) num_ends += list.size();
  link.is_closed = num_ends == 3 * corners.size();
  for (int axis = 0; axis < static_cast<int>(link.things.size()); ++axis) {
    std::vector<Pair> around;
    for (const auto& corner : corners) {
      const auto at = std::find(corner.begin(), corner.end(), axis) - corner.begin();
      if (at < 3) around.push_back({corner[(at + 1) % 3], corner[(at + 2) % 3]});
    }
    std::vector<int> ring = ring_of(around);
    // Beside the ring and its axis there is the axis' other half, if it goes on.
    const std::size_t others = link.things.size() - 1 - ring.size();
    if (!ring.empty() && others == (link.is_closed ? 1 : 0)) link.rings.push_back(std::move(ring));
  }
  return link;
}

Link link_of_edge(const HexTopology& topology, std::uint32_t edge) {
  Link link;
  std::vector<Pair> pairs;
  for (const std::uint32_t cell : topology.cells_of_edge.of(edge)) {
    const auto& edges = topology.cell_edges[cell];
    const auto local =
        static_cast<int>(std::find(edges.begin(), edges.end(), edge) - edges.begin());
    const int corner = first_corner_of_edge(local), axis = local / 4;
    Pair pair{};
    for (int k = 0; k < 2; ++k) {
      const int across = (axis + 1 + k) % 3;
      const int face = across * 2 + (corner >> across & 1);
      pair[k] = position_of(link, topology.cell_faces[cell][static_cast<std::size_t>(face)]);
    }
    join(link, pair);
    pairs.push_back(pair);
  }
  std::vector<int> ring = ring_of(pairs);
  link.is_closed = ring.size() == link.things.size();
  if (link.is_closed) link.rings.push_back(std::move(ring));
  return link;
}

double ring_weight(std::size_t count, std::size_t steps) noexcept {
  const auto k = static_cast<double>(count);
  // With three there is no second harmonic of its own; the mean and the first are kept.
  if (count <= 3) return 2 / k - (steps == 0 ? 1 : 0);
  if (count == 4) return steps == 2 ? 1 : 0;
  const double angle = 2 * std::numbers::pi * static_cast<double>(steps) / k;
  return (1 - 2 * std::cos(angle) + 2 * std::cos(2 * angle)) / k;
}

std::vector<double> straight_on(const Link& link, std::size_t from) {
  const std::size_t count = link.things.size();
  std::vector<std::size_t> apart;  // what is not next to it
  for (std::size_t i = 0; i < count; ++i) {
    const auto& next = link.next[from];
    if (i != from && std::find(next.begin(), next.end(), static_cast<int>(i)) == next.end())
      apart.push_back(i);
  }
  if (apart.size() == 1) return share(count, apart);
  if (const std::vector<int> ring = ring_from(link, from); !ring.empty()) {
    std::vector<double> weights(count);
    for (std::size_t steps = 0; steps < ring.size(); ++steps)
      weights[static_cast<std::size_t>(ring[steps])] = ring_weight(ring.size(), steps);
    return weights;
  }
  if (!apart.empty()) return share(count, apart);
  if (!link.is_closed) return {};
  // Reflected in the mean of all.
  std::vector<double> weights(count, 2 / static_cast<double>(count));
  weights[from] -= 1;
  return weights;
}

}  // namespace ovoid::solid
