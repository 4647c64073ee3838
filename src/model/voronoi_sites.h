// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <stop_token>
#include <vector>

#include "model/ellipsoid_shape.h"

namespace ovoid::model {

// Kernels of scattered sites [n, 3] (finite) by their Voronoi cells in a box a little larger than
// theirs [Hong 2009]: bisectors d of the faces that a cell shares with others, weighted by
// face area times |d|, and the cell's volume. Open cells at the hull are as large as the box makes
// them; kernel_of_volume() keeps their kernels to what the bisectors say. Sites at the place of
// another, and those without a cell of their own, are alone. Cost: some 30 microseconds per site,
// on one thread. Throws Error(kCancelled).
std::vector<SiteKernel> voronoi_kernels(std::span<const double> sites, const std::stop_token& stop);

}  // namespace ovoid::model
