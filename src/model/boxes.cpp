// SPDX-License-Identifier: Apache-2.0
#include "model/boxes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "ovoid/error.h"

namespace ovoid::model {

Boxes load_boxes(const ModelRun& run) {
  Boxes boxes;
  boxes.centers = load_positions(run);
  DataArray named = run.dataset.box_sizes;
  if (named.name.empty()) named.name = "box sizes";
  boxes.edges = load_tuples(named, run.dataset.num_positions(), 3, "boxes");
  for (std::size_t i = 0; i < boxes.edges.size(); ++i) {
    const double edge = boxes.edges[i];
    if (!(edge > 0) || !std::isfinite(edge))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("{}[{}][{}] = {}: must be > 0", named.name, i / 3, i % 3, edge));
  }
  return boxes;
}

Mesh mesh_of_boxes(const Boxes& boxes) {
  // A power of two, so that places on the grid are exact.
  const double least = *std::min_element(boxes.edges.begin(), boxes.edges.end());
  const double pitch = std::exp2(std::floor(std::log2(least / 1000)));
  // In VTK's order.
  constexpr std::array<std::array<double, 3>, 8> kCorners = {{{-1, -1, -1},
                                                              {1, -1, -1},
                                                              {1, 1, -1},
                                                              {-1, 1, -1},
                                                              {-1, -1, 1},
                                                              {1, -1, 1},
                                                              {1, 1, 1},
                                                              {-1, 1, 1}}};
  std::vector<double> places;
  places.reserve(boxes.count() * kCorners.size() * 3);
  for (std::size_t i = 0; i < boxes.count(); ++i) {
    for (const auto& corner : kCorners) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t at = 3 * i + axis;
        const double place = boxes.centers[at] + 0.5 * corner[axis] * boxes.edges[at];
        places.push_back(std::round(place / pitch) * pitch);
      }
    }
  }
  Mesh mesh;
  mesh.nodes = nodes_at(std::move(places));
  MeshCells& cells = mesh.cells;
  cells.own_types.assign(boxes.count(), CellType::kHexahedron);
  for (std::size_t i = 0; i <= boxes.count(); ++i)
    cells.own_offsets.push_back(static_cast<std::int64_t>(i * kCorners.size()));
  for (std::uint32_t node = 0; node < mesh.nodes.count(); ++node)
    cells.own_connectivity.push_back(node);
  cells.types = cells.own_types;
  cells.offsets = cells.own_offsets;
  cells.connectivity = cells.own_connectivity;
  return mesh;
}

}  // namespace ovoid::model
