// SPDX-License-Identifier: Apache-2.0
// Meshes and boxes: which sites become kernels, and what is said about the others.
#include <fmt/format.h>

#include <cmath>

#include "data/parallel.h"
#include "model/boxes.h"
#include "model/ellipsoid_set.h"
#include "model/mesh_cells.h"
#include "model/mesh_ellipsoids.h"
#include "model/voronoi_sites.h"
#include "ovoid/error.h"

namespace ovoid::model {

namespace {

// Cells turned inside out against most of the solid ones, and solid cells without volume.
void note_on_cells(const ModelRun& run, const MeshCells& cells, const CellMeasures& measures) {
  std::int64_t positive = 0, negative = 0, empty = 0, misplaced = 0;
  for (std::size_t c = 0; c < cells.count(); ++c) {
    const double volume = measures.volumes[c];
    if (!measures.is_placed(c)) {
      ++misplaced;
    } else if (volume > 0) {
      ++positive;
    } else if (volume < 0) {
      ++negative;
    } else if (table_of(cells.types[c]).dimension == 3 &&
               !table_of(cells.types[c]).has_any_nodes()) {
      ++empty;
    }
  }
  auto& notes = run.report.notes;
  if (std::min(positive, negative) > 0)
    notes.push_back(fmt::format("{} of {} cells are inside out; their volume counts all the same",
                                std::min(positive, negative), cells.count()));
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

EllipsoidSites node_sites(const ModelRun& run, const MeshNodes& nodes, const MeshCells& cells,
                          const CellMeasures& measures, const ChosenArrays& chosen) {
  SiteValues values = load_values(run, chosen, run.dataset.num_positions(), "nodes");
  merge_values(nodes, values);
  const std::vector<SiteKernel> kernels = node_kernels(run, nodes, cells, measures);
  EllipsoidSites sites;
  sites.parts.attributes = values.attributes;
  for (std::uint32_t node = 0; node < nodes.count(); ++node) {
    if (nodes.stands_for(node) != node) continue;
    if (!nodes.is_placed(node)) {
      ++run.report.num_misplaced;
    } else if (kernels[node].is_dangling) {
      ++run.report.num_dangling;
    } else if (!values.is_finite(node)) {
      ++run.report.num_missing;
    } else {
      append_site(sites.parts, nodes.at(node), values, node);
      sites.kernels.push_back(kernels[node]);
    }
  }
  run.report.num_sites = static_cast<std::int64_t>(nodes.count());
  run.report.num_merged = nodes.num_merged;
  return sites;
}

EllipsoidSites cell_sites(const ModelRun& run, const MeshNodes& nodes, const MeshCells& cells,
                          const CellMeasures& measures, const ChosenArrays& chosen) {
  const auto count = static_cast<std::int64_t>(cells.count());
  const SiteValues values = load_values(run, chosen, count, "cells");
  EllipsoidSites sites;
  sites.parts.attributes = values.attributes;
  for (std::size_t c = 0; c < cells.count(); ++c) {
    if (!measures.is_placed(c) || cells.nodes(c).empty()) {
      ++run.report.num_misplaced;
    } else if (!values.is_finite(c)) {
      ++run.report.num_missing;
    } else {
      const CellMoments moments = moments_of(nodes, cells.nodes(c));
      append_site(sites.parts, moments.mean, values, c);
      sites.kernels.push_back(cell_kernel(moments, std::abs(measures.volumes[c])));
    }
  }
  run.report.num_sites = count;
  return sites;
}

// Throws where no site is left.
void require_sites(const ModelRun& run, const EllipsoidSites& sites, const char* noun) {
  if (sites.parts.count() > 0) return;
  const KernelModelReport& report = run.report;
  throw Error(
      ErrorCode::kInvalidArgument,
      fmt::format("'{}': no kernel: of {} {}, {} have no finite value of '{}', {} no finite "
                  "position, {} no cell",
                  run.dataset.source, report.num_sites, noun, report.num_missing, report.array,
                  report.num_misplaced, report.num_dangling));
}

}  // namespace

KernelParts mesh_kernels(const ModelRun& run) {
  const ChosenArrays chosen = choose_arrays(run);
  const MeshNodes nodes = load_nodes(run);
  const MeshCells cells = load_cells(run);
  const CellMeasures measures = measure_cells(run, nodes, cells);
  note_on_cells(run, cells, measures);
  EllipsoidSites sites = chosen.is_cell_data ? cell_sites(run, nodes, cells, measures, chosen)
                                             : node_sites(run, nodes, cells, measures, chosen);
  require_sites(run, sites, chosen.is_cell_data ? "cells" : "nodes");
  if (run.options.neighborhood == Neighborhood::kVoronoi)
    sites.kernels = voronoi_kernels(sites.parts.centers, run.stop);
  return fit_ellipsoids(run, std::move(sites));
}

KernelParts box_kernels(const ModelRun& run) {
  const ChosenArrays chosen = choose_arrays(run);
  const Boxes boxes = load_boxes(run);
  const auto count = static_cast<std::int64_t>(boxes.count());
  const SiteValues values = load_values(run, chosen, count, "boxes");
  EllipsoidSites sites;
  sites.parts.attributes = values.attributes;
  run.report.num_sites = count;
  for (std::size_t i = 0; i < boxes.count(); ++i) {
    if (!boxes.center(i).allFinite()) {
      ++run.report.num_misplaced;
    } else if (!values.is_finite(i)) {
      ++run.report.num_missing;
    } else {
      append_site(sites.parts, boxes.center(i), values, i);
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
