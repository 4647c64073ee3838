// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <vector>

#include "model/mesh/ellipsoid_shape.h"

namespace ovoid::model {

// A site's Voronoi cell in a box a little larger than that of all sites, world units.
struct VoronoiCell {
  std::vector<Vec3> feet;      // from the site halfway to each with which it shares a face
  std::vector<double> shares;  // of each: face area times foot length, in any one unit
  double volume = 0;
  bool is_open = false;  // the box cuts it
};

// Calls visit(site, cell) for each of the sites [n, 3] (finite) that has a cell of its own: of
// those at one place the first. Cost and errors as of voronoi_kernels().
void visit_voronoi_cells(std::span<const double> sites,
                         const std::function<void(std::uint32_t site, const VoronoiCell&)>& visit,
                         const std::stop_token& stop);

// 3 / sum s * sum s d d^T over the feet d with their shares s: the covariance of the kernel that
// belongs to the cell, for a lattice's cell (T / 2)^2.
Mat3 spread_of(const VoronoiCell& cell);

// Kernels of scattered sites [n, 3] (finite) by their Voronoi cells in a box a little larger than
// theirs [Hong 2009]: bisectors d of the faces that a cell shares with others, weighted by
// face area times |d|, and the cell's volume. Open cells at the hull are as large as the box makes
// them; kernel_of_volume() keeps their kernels to what the bisectors say. Sites at the place of
// another, and those without a cell of their own, are alone. Cost: some 30 microseconds per site,
// on one thread. Throws Error(kCancelled).
std::vector<SiteKernel> voronoi_kernels(std::span<const double> sites, const std::stop_token& stop);

}  // namespace ovoid::model
