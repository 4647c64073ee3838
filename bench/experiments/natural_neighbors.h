// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

namespace ovoid::experiments {

// Sibson's interpolation of the sites' values at places [n, 3] within them [Sibson 1981]: a site's
// share at a place is the volume that the place's own Voronoi cell would take of the site's. Exact
// for linear functions, except at the hull. Cost: about half a millisecond per place.
std::vector<double> natural_neighbor_values(std::span<const double> sites,
                                            std::span<const double> values,
                                            std::span<const double> places);

}  // namespace ovoid::experiments
