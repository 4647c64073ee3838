// SPDX-License-Identifier: Apache-2.0
#include "model/mesh/mesh_cells.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "data/parallel.h"
#include "model/team/team_run.h"
#include "ovoid/error.h"

namespace ovoid::model {

namespace {

[[noreturn]] void refuse_mesh(const ModelRun& run, const std::string& what) {
  throw Error(ErrorCode::kInvalidArgument, fmt::format("'{}': {}", run.dataset.source, what));
}

void point_at_own(MeshCells& cells) {
  cells.types = cells.own_types;
  cells.offsets = cells.own_offsets;
  cells.connectivity = cells.own_connectivity;
}

// Hexahedra between the nodes of a grid, quads in a plane, lines along an axis.
void write_out_grid(const Index3& dims, MeshCells& cells) {
  std::vector<int> axes;
  for (int axis = 0; axis < 3; ++axis) {
    if (dims[axis] > 1) axes.push_back(axis);
  }
  constexpr CellType kByDimension[] = {CellType::kVertex, CellType::kLine, CellType::kQuad,
                                       CellType::kHexahedron};
  const CellType type = kByDimension[axes.size()];
  const Index3 stride = {1, dims[0], dims[0] * dims[1]};
  std::vector<std::int64_t> corners = {0};
  for (const int axis : axes) {  // the second row of a quad runs backwards, a layer as the first
    const std::size_t n = corners.size();
    for (std::size_t i = 0; i < n; ++i)
      corners.push_back(corners[n == 2 ? n - 1 - i : i] + stride[axis]);
  }
  const Index3 size = {std::max<std::int64_t>(dims[0] - 1, 1),
                       std::max<std::int64_t>(dims[1] - 1, 1),
                       std::max<std::int64_t>(dims[2] - 1, 1)};
  const auto count = static_cast<std::size_t>(size[0] * size[1] * size[2]);
  cells.own_types.assign(count, type);
  cells.own_offsets.reserve(count + 1);
  cells.own_offsets.push_back(0);
  cells.own_connectivity.reserve(count * corners.size());
  for (std::int64_t k = 0; k < size[2]; ++k) {
    for (std::int64_t j = 0; j < size[1]; ++j) {
      for (std::int64_t i = 0; i < size[0]; ++i) {
        const std::int64_t first = i + j * stride[1] + k * stride[2];
        for (const std::int64_t corner : corners)
          cells.own_connectivity.push_back(static_cast<std::uint32_t>(first + corner));
        cells.own_offsets.push_back(static_cast<std::int64_t>(cells.own_connectivity.size()));
      }
    }
  }
  point_at_own(cells);
}

void check_cells(const ModelRun& run, const MeshCells& cells) {
  const std::int64_t num_nodes = run.dataset.num_positions();
  if (total_of(run, static_cast<std::int64_t>(cells.count())) == 0)
    refuse_mesh(run, "has no cells; as points alone it is no mesh");
  if (cells.count() == 0) return;
  if (cells.count() >= std::numeric_limits<std::uint32_t>::max())
    refuse_mesh(run, fmt::format("{} cells, must be fewer than {}", cells.count(),
                                 std::numeric_limits<std::uint32_t>::max()));
  if (cells.offsets.size() != cells.count() + 1 || cells.offsets[0] != 0 ||
      cells.offsets.back() != static_cast<std::int64_t>(cells.connectivity.size()))
    refuse_mesh(run, fmt::format("cell offsets: must be {} numbers from 0 to {}", cells.count() + 1,
                                 cells.connectivity.size()));
  for (std::size_t c = 0; c < cells.count(); ++c) {
    if (cells.offsets[c + 1] < cells.offsets[c])
      refuse_mesh(run, fmt::format("cell offsets[{}] = {}: must be >= offsets[{}] = {}", c + 1,
                                   cells.offsets[c + 1], c, cells.offsets[c]));
  }
  for (std::size_t c = 0; c < cells.count(); ++c) {
    const auto nodes = cells.nodes(c);
    if (cells.types[c] > CellType::kOther)
      refuse_mesh(
          run, fmt::format("cells[{}]: type {} is unknown", c, static_cast<int>(cells.types[c])));
    const int expected = table_of(cells.types[c]).num_nodes;
    if (expected != 0 && nodes.size() != static_cast<std::size_t>(expected))
      refuse_mesh(run,
                  fmt::format("cells[{}]: {} nodes, its type has {}", c, nodes.size(), expected));
    for (const std::uint32_t node : nodes) {
      if (node >= num_nodes)
        refuse_mesh(run, fmt::format("cells[{}]: node {}, must be under {}", c, node, num_nodes));
    }
  }
}

double det(const Vec3& a, const Vec3& b, const Vec3& c) noexcept { return a.dot(b.cross(c)); }

// By the divergence theorem, each face a fan around its middle, so that neighbours agree on it.
double volume_by_faces(const CellTable& table, const MeshNodes& nodes,
                       std::span<const std::uint32_t> cell) noexcept {
  const Vec3 origin = nodes.at(cell[0]);
  double sum = 0;
  for (const auto& face : table.faces) {
    Vec3 middle = Vec3::Zero();
    for (const std::uint8_t node : face) middle += nodes.at(cell[node]) - origin;
    middle /= static_cast<double>(face.size());
    Vec3 last = nodes.at(cell[face.back()]) - origin;
    for (const std::uint8_t node : face) {
      const Vec3 next = nodes.at(cell[node]) - origin;
      sum += det(middle, last, next);
      last = next;
    }
  }
  return sum / 6;
}

double volume_of(const MeshNodes& nodes, const MeshCells& cells, std::size_t cell) noexcept {
  const auto list = cells.nodes(cell);
  for (const std::uint32_t node : list) {
    if (!nodes.is_placed(node)) return std::numeric_limits<double>::quiet_NaN();
  }
  const CellTable& table = table_of(cells.types[cell]);
  if (table.has_any_nodes()) {
    // Of a box, the edges are twice the roots of its corners' covariance.
    const Mat3 covariance = moments_of(nodes, list).covariance;
    const double trace = covariance.trace();
    const double determinant = covariance.determinant();
    const bool is_solid = determinant > 1e-12 * trace * trace * trace;
    return is_solid ? 8 * std::sqrt(determinant) : 0.0;
  }
  if (cells.types[cell] == CellType::kTetrahedron) {
    const Vec3 p = nodes.at(list[0]);
    return det(nodes.at(list[1]) - p, nodes.at(list[2]) - p, nodes.at(list[3]) - p) / 6;
  }
  return table.dimension == 3 ? volume_by_faces(table, nodes, list) : 0.0;
}

}  // namespace

std::size_t PlaceHash::operator()(const Vec3& place) const noexcept {
  std::uint64_t hash = 0;
  for (const double coordinate : place) {
    hash = (hash ^ std::bit_cast<std::uint64_t>(coordinate + 0.0)) * 0x9E3779B97F4A7C15U;
    hash ^= hash >> 32;
  }
  return hash;
}

MeshNodes merged_nodes(std::vector<double> places) {
  MeshNodes nodes;
  nodes.positions = std::move(places);
  const std::size_t mask = std::bit_ceil(2 * nodes.count()) - 1;
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> table(mask + 1, kNone);
  std::vector<std::uint32_t> representative(nodes.count());
  for (std::uint32_t node = 0; node < nodes.count(); ++node) {
    representative[node] = node;
    if (!nodes.is_placed(node)) continue;
    const Vec3 place = nodes.at(node);
    std::size_t slot = PlaceHash()(place) & mask;
    while (table[slot] != kNone && nodes.at(table[slot]) != place) slot = (slot + 1) & mask;
    if (table[slot] == kNone) {
      table[slot] = node;
    } else {
      representative[node] = table[slot];
      ++nodes.num_merged;
    }
  }
  if (nodes.num_merged > 0) nodes.representative = std::move(representative);
  return nodes;
}

MeshNodes load_nodes(const ModelRun& run) { return merged_nodes(load_positions(run)); }

MeshCells cells_owning(std::vector<CellType> types, std::vector<std::int64_t> offsets,
                       std::vector<std::uint32_t> connectivity) {
  MeshCells cells;
  cells.own_types = std::move(types);
  cells.own_offsets = std::move(offsets);
  cells.own_connectivity = std::move(connectivity);
  point_at_own(cells);
  return cells;
}

MeshCells load_cells(const ModelRun& run) {
  const Cells& from = run.dataset.cells;
  MeshCells cells;
  if (!from.is_structured()) {
    cells.types = from.types;
    cells.offsets = from.offsets;
    cells.connectivity = from.connectivity;
  } else {
    const Index3& dims = from.dims;
    const std::int64_t num_nodes = run.dataset.num_positions();
    // Compared by division: a product of what a dataset claims may not fit 64 bits.
    if (dims[1] < 1 || dims[2] < 1 || num_nodes % dims[0] != 0 ||
        num_nodes / dims[0] % dims[1] != 0 || num_nodes / dims[0] / dims[1] != dims[2])
      refuse_mesh(run, fmt::format("grid of {} x {} x {} nodes: there are {} positions", dims[0],
                                   dims[1], dims[2], num_nodes));
    write_out_grid(dims, cells);
  }
  check_cells(run, cells);
  return cells;
}

CellMoments moments_of(const MeshNodes& nodes, std::span<const std::uint32_t> cell) noexcept {
  CellMoments moments;
  if (cell.empty()) return moments;
  const Vec3 origin = nodes.at(cell[0]);
  for (const std::uint32_t node : cell) moments.mean += nodes.at(node) - origin;
  moments.mean /= static_cast<double>(cell.size());
  for (const std::uint32_t node : cell) {
    const Vec3 d = nodes.at(node) - origin - moments.mean;
    moments.covariance += d * d.transpose();
  }
  moments.covariance /= static_cast<double>(cell.size());
  moments.mean += origin;
  return moments;
}

const CellMoments& CellMeasures::moments_of_other(std::uint32_t cell) const noexcept {
  const auto found = std::lower_bound(others.begin(), others.end(), cell);
  return other_moments[static_cast<std::size_t>(found - others.begin())];
}

CellMeasures measure_cells(const ModelRun& run, const MeshNodes& nodes, const MeshCells& cells) {
  CellMeasures measures;
  measures.volumes.resize(cells.count());
  data::parallel_ranges(
      {static_cast<std::int64_t>(cells.count()), kSiteGrain, run.threads, run.stop},
      [&](std::int64_t begin, std::int64_t end) {
        for (auto c = static_cast<std::size_t>(begin); c < static_cast<std::size_t>(end); ++c)
          measures.volumes[c] = volume_of(nodes, cells, c);
      });
  for (std::size_t c = 0; c < cells.count(); ++c) {
    if (!table_of(cells.types[c]).has_any_nodes()) continue;
    measures.others.push_back(static_cast<std::uint32_t>(c));
    measures.other_moments.push_back(moments_of(nodes, cells.nodes(c)));
  }
  return measures;
}

}  // namespace ovoid::model
