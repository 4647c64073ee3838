// SPDX-License-Identifier: Apache-2.0
#include "model/mesh/cell_tables.h"

#include <algorithm>
#include <array>
#include <utility>

namespace ovoid::model {

namespace {

using Cycle = std::vector<std::uint8_t>;
using Cycles = std::vector<Cycle>;

// The nodes that a face adds to what surrounds `node`, from the one after it in the cycle to the
// one before. Next to a middle node lie the middle nodes of the adjacent edges.
Cycle path_around(const Cycle& face, std::size_t at, bool is_curved) {
  const std::size_t n = face.size();
  Cycle path = {face[(at + 1) % n]};
  if (is_curved && at % 2 == 1) {
    path.push_back(face[(at + 2) % n]);
    path.push_back(face[(at + n - 2) % n]);
  }
  path.push_back(face[(at + n - 1) % n]);
  return path;
}

// Joins the paths of the faces around a node end to end.
Cycle fan_of(std::vector<Cycle> paths) {
  Cycle fan;
  std::uint8_t end = paths.front().front();
  while (!paths.empty()) {
    const auto next = std::find_if(paths.begin(), paths.end(),
                                   [&](const Cycle& path) { return path.front() == end; });
    if (next == paths.end()) break;
    fan.insert(fan.end(), next->begin(), next->end() - 1);
    end = next->back();
    paths.erase(next);
  }
  return fan;
}

// `num_corners`: nodes from there on are middle nodes, every second of each face.
CellTable solid(int num_nodes, int num_corners, Cycles faces) {
  CellTable table;
  table.num_nodes = num_nodes;
  table.faces = std::move(faces);
  const bool is_curved = num_nodes > num_corners;
  for (int node = 0; node < num_nodes; ++node) {
    std::vector<Cycle> paths;
    for (const Cycle& face : table.faces) {
      const auto found = std::find(face.begin(), face.end(), node);
      if (found == face.end()) continue;
      paths.push_back(path_around(face, static_cast<std::size_t>(found - face.begin()), is_curved));
    }
    Cycle fan = paths.empty() ? Cycle{} : fan_of(paths);
    // The ends of a middle node's edge are opposite each other; what lies between is not.
    if (node >= num_corners && !fan.empty()) std::rotate(fan.begin(), fan.begin() + 1, fan.end());
    table.neighbors.push_back(fan);
    table.fans.push_back(std::move(fan));
  }
  return table;
}

CellTable flat(int dimension, Cycles neighbors) {
  CellTable table;
  table.num_nodes = static_cast<int>(neighbors.size());
  table.dimension = dimension;
  table.neighbors = std::move(neighbors);
  return table;
}

const Cycles kHexFaces = {{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4},
                          {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}};
const Cycles kCurvedHexFaces = {{0, 16, 4, 15, 7, 19, 3, 11}, {1, 9, 2, 18, 6, 13, 5, 17},
                                {0, 8, 1, 17, 5, 12, 4, 16},  {3, 19, 7, 14, 6, 18, 2, 10},
                                {0, 11, 3, 10, 2, 9, 1, 8},   {4, 12, 5, 13, 6, 14, 7, 15}};

// The 27 nodes: those of the faces and the middle of the cell join what lies straight across.
CellTable tri_quadratic() {
  CellTable table = solid(20, 8, kCurvedHexFaces);
  table.num_nodes = 27;
  const Cycles more = {{16, 15, 19, 11},        {9, 18, 13, 17}, {8, 17, 12, 16},
                       {19, 14, 18, 10},        {11, 10, 9, 8},  {12, 13, 14, 15},
                       {20, 21, 22, 23, 24, 25}};
  for (const Cycle& around : more) {
    table.neighbors.push_back(around);
    table.fans.emplace_back();
  }
  for (std::size_t node = 20; node < 26; ++node) table.neighbors[node].push_back(26);
  return table;
}

std::array<CellTable, static_cast<std::size_t>(CellType::kOther) + 1> make_tables() {
  std::array<CellTable, static_cast<std::size_t>(CellType::kOther) + 1> tables;
  const auto at = [&](CellType type) -> CellTable& {
    return tables[static_cast<std::size_t>(type)];
  };
  at(CellType::kVertex) = flat(0, {{}});
  at(CellType::kLine) = flat(1, {{1}, {0}});
  at(CellType::kTriangle) = flat(2, {{1, 2}, {2, 0}, {0, 1}});
  at(CellType::kQuad) = flat(2, {{1, 3}, {2, 0}, {3, 1}, {0, 2}});
  at(CellType::kTetrahedron) = solid(4, 4, {{0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {0, 2, 1}});
  at(CellType::kHexahedron) = solid(8, 8, kHexFaces);
  Cycles voxel_faces = kHexFaces;
  for (Cycle& face : voxel_faces) {
    for (std::uint8_t& node : face) {
      if (node % 4 >= 2) node ^= 1;  // its second row runs the other way
    }
  }
  at(CellType::kVoxel) = solid(8, 8, voxel_faces);
  at(CellType::kWedge) =
      solid(6, 6, {{0, 1, 2}, {3, 5, 4}, {0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}});
  at(CellType::kPyramid) = solid(5, 5, {{0, 3, 2, 1}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}});
  at(CellType::kQuadraticTetrahedron) = solid(
      10, 4, {{0, 4, 1, 8, 3, 7}, {1, 5, 2, 9, 3, 8}, {2, 6, 0, 7, 3, 9}, {0, 6, 2, 5, 1, 4}});
  at(CellType::kQuadraticHexahedron) = solid(20, 8, kCurvedHexFaces);
  at(CellType::kQuadraticWedge) = solid(15, 6,
                                        {{0, 6, 1, 7, 2, 8},
                                         {3, 11, 5, 10, 4, 9},
                                         {0, 12, 3, 9, 4, 13, 1, 6},
                                         {1, 13, 4, 10, 5, 14, 2, 7},
                                         {2, 14, 5, 11, 3, 12, 0, 8}});
  at(CellType::kQuadraticPyramid) = solid(13, 5,
                                          {{0, 8, 3, 7, 2, 6, 1, 5},
                                           {0, 5, 1, 10, 4, 9},
                                           {1, 6, 2, 11, 4, 10},
                                           {2, 7, 3, 12, 4, 11},
                                           {3, 8, 0, 9, 4, 12}});
  at(CellType::kTriQuadraticHexahedron) = tri_quadratic();
  at(CellType::kPolyLine) = CellTable{};
  at(CellType::kOther) = CellTable{};
  return tables;
}

}  // namespace

const CellTable& table_of(CellType type) {
  static const auto tables = make_tables();
  return tables[static_cast<std::size_t>(type)];
}

}  // namespace ovoid::model
