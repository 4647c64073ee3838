// SPDX-License-Identifier: Apache-2.0
// What is a mesh of hexahedra, from and to datasets.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "data/cell_builder.h"
#include "data/parallel.h"
#include "model/mesh/mesh_cells.h"
#include "model/own_array.h"
#include "ovoid/error.h"
#include "solid/corner_frames.h"
#include "solid/hex_topology.h"

namespace ovoid {

namespace solid {

namespace {

// VTK's hexahedra go around each of two faces, its voxels along rows.
constexpr std::array<std::size_t, 8> kVoxelOrder = {0, 1, 3, 2, 4, 5, 7, 6};

[[noreturn]] void refuse_solid(const std::string& message) {
  throw Error(ErrorCode::kInvalidArgument, message);
}

void check_numbers(const SolidMesh& mesh) {
  if (mesh.cells.empty()) refuse_solid("cells: none, expected hexahedra");
  const std::size_t count = mesh.num_vertices();
  if (mesh.positions.size() != 3 * count)
    refuse_solid(fmt::format("positions: {} numbers, expected 3 for each of {} densities",
                             mesh.positions.size(), count));
  for (std::size_t v = 0; v < count; ++v) {
    const Vec3 at = mesh.position(v);
    if (!at.allFinite())
      refuse_solid(fmt::format("positions[{}] = {} {} {}: must be finite", v, at[0], at[1], at[2]));
    if (!std::isfinite(mesh.densities[v]))
      refuse_solid(fmt::format("densities[{}] = {}: must be finite", v, mesh.densities[v]));
  }
}

void check_vertices(const SolidMesh& mesh) {
  std::vector<bool> has_cell(mesh.num_vertices());
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    const CellVertices& cell = mesh.cells[c];
    for (std::size_t corner = 0; corner < cell.size(); ++corner) {
      if (cell[corner] >= mesh.num_vertices())
        refuse_solid(fmt::format("cells[{}]: vertex {}, must be under {}", c, cell[corner],
                                 mesh.num_vertices()));
      for (std::size_t before = 0; before < corner; ++before) {
        if (cell[before] == cell[corner])
          refuse_solid(fmt::format("cells[{}]: vertex {} twice, expected a hexahedron of 8 places",
                                   c, cell[corner]));
      }
      has_cell[cell[corner]] = true;
    }
  }
  for (std::size_t v = 0; v < has_cell.size(); ++v) {
    if (!has_cell[v]) refuse_solid(fmt::format("positions[{}]: a vertex of no cell", v));
  }
}

std::array<std::uint32_t, 4> as_set(std::array<std::uint32_t, 4> edges) {
  std::sort(edges.begin(), edges.end());
  return edges;
}

void check_faces(const HexTopology& topology) {
  for (std::size_t f = 0; f < topology.faces.size(); ++f) {
    const auto cells = topology.cells_of_face.of(f);
    if (cells.size() > 2)
      refuse_solid(fmt::format("cells[{}], [{}] and [{}]: have one face; expected two at most",
                               cells[0], cells[1], cells[2]));
  }
  for (std::size_t c = 0; c < topology.cell_faces.size(); ++c) {
    for (int local = 0; local < kCellFaces; ++local) {
      const std::uint32_t face = topology.cell_faces[c][static_cast<std::size_t>(local)];
      if (as_set(edges_of_face(topology, c, local)) == as_set(topology.face_edges[face])) continue;
      refuse_solid(fmt::format("cells[{}] and [{}]: share four vertices, but not the edges between",
                               topology.cells_of_face.of(face)[0], c));
    }
  }
}

// Whether all corners turn as the mesh does on the whole.
void check_turns(const SolidMesh& mesh) {
  double sum = 0;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    for (int corner = 0; corner < kCellCorners; ++corner)
      sum += corner_frame(mesh, c, corner).determinant();
  }
  const double turn = sum < 0 ? -1 : 1;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    for (int corner = 0; corner < kCellCorners; ++corner) {
      const double volume = turn * corner_frame(mesh, c, corner).determinant();
      if (volume > 0) continue;
      refuse_solid(fmt::format(
          "cells[{}]: {} at vertex {}: expected edges that turn there as in the rest "
          "of the mesh",
          c, volume < 0 ? "inside out" : "flat", mesh.cells[c][static_cast<std::size_t>(corner)]));
    }
  }
}

const char* name_of_cell(CellType type) {
  switch (type) {
    case CellType::kTetrahedron:
    case CellType::kQuadraticTetrahedron:
      return "a tetrahedron";
    case CellType::kWedge:
    case CellType::kQuadraticWedge:
      return "a wedge";
    case CellType::kPyramid:
    case CellType::kQuadraticPyramid:
      return "a pyramid";
    case CellType::kQuadraticHexahedron:
    case CellType::kTriQuadraticHexahedron:
      return "a curved hexahedron";
    case CellType::kOther:
      return "a cell of another shape";
    default:
      return "flat";
  }
}

// Vertices of the nodes that cells have, in the nodes' order.
class ControlVertices {
 public:
  ControlVertices(const model::MeshNodes& nodes, const model::MeshCells& cells)
      : vertex_of_(nodes.count(), kNone) {
    for (const std::uint32_t node : cells.connectivity) vertex_of_[nodes.stands_for(node)] = 0;
    for (std::uint32_t node = 0; node < nodes.count(); ++node) {
      if (vertex_of_[node] == kNone) continue;
      vertex_of_[node] = static_cast<std::uint32_t>(nodes_.size());
      nodes_.push_back(node);
    }
  }
  std::uint32_t of_node(std::uint32_t node) const { return vertex_of_[node]; }
  const std::vector<std::uint32_t>& nodes() const { return nodes_; }

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> vertex_of_, nodes_;
};

CellVertices hexahedron_of(const model::MeshCells& cells, std::size_t c) {
  const CellType type = cells.types[c];
  if (type != CellType::kHexahedron && type != CellType::kVoxel)
    refuse_solid(fmt::format(
        "cells[{}]: is {}, expected hexahedra of 8 nodes alone; a mesher for hexahedra, or parts "
        "of the mesh without other cells, will do",
        c, name_of_cell(type)));
  CellVertices nodes{};
  for (std::size_t corner = 0; corner < nodes.size(); ++corner)
    nodes[corner] = cells.nodes(c)[type == CellType::kVoxel ? corner : kVoxelOrder[corner]];
  return nodes;
}

// What check_solid_mesh() says of vertices and cells, as the file numbers them, is worth more to
// who has the file.
void check_places(const model::MeshNodes& nodes, const ControlVertices& vertices,
                  const model::SiteValues& values) {
  for (const std::uint32_t node : vertices.nodes()) {
    if (!nodes.is_placed(node))
      refuse_solid(fmt::format("node {}: its position is not finite", node));
    if (!values.is_finite(node))
      refuse_solid(fmt::format("node {}: has no value of '{}', expected a number at every node",
                               node, values.attributes[0].name));
  }
}

SolidMesh control_mesh_of(const model::ModelRun& run) {
  const model::ChosenArrays chosen = model::choose_arrays(run);
  if (chosen.is_cell_data)
    refuse_solid(
        fmt::format("array '{}': has a value per cell, expected one per node", run.report.array));
  const model::MeshNodes nodes = model::load_nodes(run);
  const model::MeshCells cells = model::load_cells(run);
  const model::SiteValues values =
      model::load_values(run, chosen, run.dataset.num_positions(), "nodes");
  SolidMesh mesh;
  mesh.name = values.attributes[0].name;
  mesh.unit = values.attributes[0].unit;
  std::vector<CellVertices> hexahedra;
  for (std::size_t c = 0; c < cells.count(); ++c) hexahedra.push_back(hexahedron_of(cells, c));
  const ControlVertices vertices(nodes, cells);
  check_places(nodes, vertices, values);
  for (CellVertices& cell : hexahedra) {
    for (std::uint32_t& node : cell) node = vertices.of_node(nodes.stands_for(node));
  }
  mesh.cells = std::move(hexahedra);
  for (const std::uint32_t node : vertices.nodes()) {
    const Vec3 at = nodes.at(node);
    mesh.positions.insert(mesh.positions.end(), at.begin(), at.end());
    mesh.densities.push_back(static_cast<double>(values.columns[0][node]));
  }
  check_solid_mesh(mesh);
  return mesh;
}

}  // namespace

HexTopology checked_topology(const SolidMesh& mesh) {
  check_numbers(mesh);
  check_vertices(mesh);
  HexTopology topology = make_topology(mesh.num_vertices(), mesh.cells);
  check_faces(topology);
  return topology;
}

}  // namespace solid

void check_solid_mesh(const SolidMesh& mesh) {
  solid::checked_topology(mesh);
  solid::check_turns(mesh);
}

SolidMesh make_control_mesh(const Dataset& mesh, const ControlMeshOptions& options) {
  const auto named = [&](const std::string& what) {
    return Error(ErrorCode::kInvalidArgument, fmt::format("'{}': {}", mesh.source, what));
  };
  if (mesh.kind != DatasetKind::kMesh)
    throw named(fmt::format("is of kind {}, expected a mesh of hexahedra", name_of(mesh.kind)));
  if (mesh.arrays.empty()) throw named("has no array, expected a density per node");
  KernelModelOptions model_options;
  model_options.array = options.array;
  model_options.component = options.component;
  KernelModelReport report;
  try {
    return solid::control_mesh_of({mesh, model_options, report});
  } catch (const Error& error) {
    if (std::string(error.what()).starts_with("'")) throw;
    throw Error(error.code(), fmt::format("'{}': {}", mesh.source, error.what()));
  }
}

Dataset make_solid_dataset(const SolidMesh& mesh) {
  solid::checked_topology(mesh);
  Dataset dataset;
  dataset.source = "solid";
  dataset.format = "solid";
  dataset.kind = DatasetKind::kMesh;
  dataset.positions = model::array_of_numbers("positions", 3, mesh.positions);
  dataset.arrays.push_back(model::array_of_numbers(
      mesh.name, 1, std::vector<float>(mesh.densities.begin(), mesh.densities.end())));
  dataset.arrays.back().unit = mesh.unit;
  data::CellBuilder cells;
  for (const auto& cell : mesh.cells) {
    std::array<std::uint32_t, 8> nodes{};
    for (std::size_t corner = 0; corner < nodes.size(); ++corner)
      nodes[corner] = cell[solid::kVoxelOrder[corner]];
    cells.add(CellType::kHexahedron, nodes);
  }
  dataset.cells = std::move(cells).finish();
  return dataset;
}

}  // namespace ovoid
