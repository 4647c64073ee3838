// SPDX-License-Identifier: Apache-2.0
// Meshes and boxes: which sites become kernels, and what is said about the others.
#include <fmt/format.h>

#include <cmath>

#include "model/mesh/boxes.h"
#include "model/mesh/ellipsoid_set.h"
#include "model/mesh/local_mesh.h"
#include "model/mesh/mesh_ellipsoids.h"
#include "model/mesh/mesh_surface.h"
#include "model/mesh/voronoi_sites.h"
#include "model/team/team_run.h"
#include "ovoid/error.h"

namespace ovoid::model {

namespace {

// Cells turned inside out against most of the solid ones, and solid cells without volume.
void note_on_cells(const ModelRun& run, const LocalMesh& mesh, const CellMeasures& measures) {
  std::int64_t count = 0, positive = 0, negative = 0, empty = 0, misplaced = 0;
  for (std::size_t c = 0; c < mesh.cells.count(); ++c) {
    if (!mesh.owns_cell(c)) continue;
    ++count;
    const double volume = measures.volumes[c];
    const CellTable& table = table_of(mesh.cells.types[c]);
    if (!measures.is_placed(c)) {
      ++misplaced;
    } else if (volume > 0) {
      ++positive;
    } else if (volume < 0) {
      ++negative;
    } else if (table.dimension == 3 && !table.has_any_nodes()) {
      ++empty;
    }
  }
  for (std::int64_t* const number : {&count, &positive, &negative, &empty, &misplaced})
    *number = total_of(run, *number);
  auto& notes = run.report.notes;
  if (std::min(positive, negative) > 0)
    notes.push_back(fmt::format("{} of {} cells are inside out; their volume counts all the same",
                                std::min(positive, negative), count));
  if (empty > 0) notes.push_back(fmt::format("{} cells have no volume", empty));
  if (misplaced > 0)
    notes.push_back(fmt::format(
        "{} cells have a node whose position is not finite and are left out", misplaced));
}

// Nodes at one place share one value: the mean of those that are finite.
void merge_values(const MeshNodes& nodes, SiteValues& values) {
  if (nodes.representative.empty()) return;
  std::vector<std::uint32_t> counts(nodes.count());
  std::vector<double> sums(nodes.count());
  for (std::vector<float>& column : values.columns) {
    std::fill(counts.begin(), counts.end(), 0);
    std::fill(sums.begin(), sums.end(), 0.0);
    for (std::uint32_t node = 0; node < nodes.count(); ++node) {
      if (!std::isfinite(column[node])) continue;
      ++counts[nodes.stands_for(node)];
      sums[nodes.stands_for(node)] += static_cast<double>(column[node]);
    }
    for (std::uint32_t node = 0; node < nodes.count(); ++node) {
      const std::uint32_t first = nodes.stands_for(node);
      if (counts[first] > 1) column[node] = static_cast<float>(sums[first] / counts[first]);
      if (counts[first] == 1) column[node] = static_cast<float>(sums[first]);
    }
  }
}

EllipsoidSites node_sites(const ModelRun& run, LocalMesh& mesh, const CellMeasures& measures) {
  const MeshNodes& nodes = mesh.nodes;
  merge_values(nodes, mesh.values);
  const std::vector<SiteKernel> kernels = node_kernels(run, nodes, mesh.cells, measures);
  EllipsoidSites sites;
  sites.parts.attributes = mesh.values.attributes;
  for (std::uint32_t node = 0; node < nodes.count(); ++node) {
    if (!mesh.owns_node(node)) continue;
    ++run.report.num_sites;
    if (nodes.stands_for(node) != node) {
      ++run.report.num_merged;
    } else if (!nodes.is_placed(node)) {
      ++run.report.num_misplaced;
    } else if (kernels[node].is_dangling) {
      ++run.report.num_dangling;
    } else if (!mesh.values.is_finite(node)) {
      ++run.report.num_missing;
    } else {
      append_site(sites.parts, nodes.at(node), mesh.values, node);
      sites.kernels.push_back(kernels[node]);
    }
  }
  return sites;
}

EllipsoidSites cell_sites(const ModelRun& run, const LocalMesh& mesh,
                          const CellMeasures& measures) {
  EllipsoidSites sites;
  sites.parts.attributes = mesh.values.attributes;
  for (std::size_t c = 0; c < mesh.cells.count(); ++c) {
    if (!mesh.owns_cell(c)) continue;
    ++run.report.num_sites;
    if (!measures.is_placed(c) || mesh.cells.nodes(c).empty()) {
      ++run.report.num_misplaced;
    } else if (!mesh.values.is_finite(c)) {
      ++run.report.num_missing;
    } else {
      const CellMoments moments = moments_of(mesh.nodes, mesh.cells.nodes(c));
      append_site(sites.parts, moments.mean, mesh.values, c);
      sites.kernels.push_back(cell_kernel(moments, std::abs(measures.volumes[c])));
    }
  }
  return sites;
}

// Throws where no site is left, of no process.
void require_sites(const ModelRun& run, const EllipsoidSites& sites, const char* noun) {
  if (total_of(run, static_cast<std::int64_t>(sites.parts.count())) > 0) return;
  const KernelModelReport& report = run.report;
  throw Error(
      ErrorCode::kInvalidArgument,
      fmt::format("'{}': no kernel: of {} {}, {} have no finite value of '{}', {} no finite "
                  "position, {} no cell",
                  run.dataset.source, total_of(run, report.num_sites), noun,
                  total_of(run, report.num_missing), report.array,
                  total_of(run, report.num_misplaced), total_of(run, report.num_dangling)));
}

}  // namespace

KernelParts mesh_kernels(const ModelRun& run) {
  const ChosenArrays chosen = choose_arrays(run);
  LocalMesh mesh = load_local_mesh(run, chosen);
  const CellMeasures measures = measure_cells(run, mesh.nodes, mesh.cells);
  note_on_cells(run, mesh, measures);
  if (run.surface != nullptr) *run.surface = surface_of_mesh(run, mesh);
  EllipsoidSites sites =
      mesh.is_cell_data ? cell_sites(run, mesh, measures) : node_sites(run, mesh, measures);
  require_sites(run, sites, mesh.is_cell_data ? "cells" : "nodes");
  mesh = {};
  if (run.options.neighborhood == Neighborhood::kVoronoi)
    sites.kernels = voronoi_kernels(sites.parts.centers, run.stop);
  return fit_ellipsoids(run, std::move(sites));
}

KernelParts box_kernels(const ModelRun& run) {
  const ChosenArrays chosen = choose_arrays(run);
  const LocalBoxes local = load_local_boxes(run, chosen);
  if (run.surface != nullptr) *run.surface = surface_of_boxes(run, local);
  const Boxes& boxes = local.boxes;
  EllipsoidSites sites;
  sites.parts.attributes = local.values.attributes;
  for (std::size_t i = 0; i < boxes.count(); ++i) {
    ++run.report.num_sites;
    if (!boxes.center(i).allFinite()) {
      ++run.report.num_misplaced;
    } else if (!local.values.is_finite(i)) {
      ++run.report.num_missing;
    } else {
      append_site(sites.parts, boxes.center(i), local.values, i);
      SiteKernel kernel;
      kernel.factor = (boxes.edge(i) / 2).asDiagonal();
      kernel.weight = kLatticeWeight;
      sites.kernels.push_back(kernel);
    }
  }
  require_sites(run, sites, "boxes");
  if (run.options.neighborhood == Neighborhood::kVoronoi)
    sites.kernels = voronoi_kernels(sites.parts.centers, run.stop);
  return fit_ellipsoids(run, std::move(sites));
}

}  // namespace ovoid::model
