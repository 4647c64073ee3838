// SPDX-License-Identifier: Apache-2.0
#include "experiments/natural_neighbors.h"

#include <algorithm>
#include <cmath>
#include <voro++/voro++.hh>

#include "ovoid/math.h"

namespace ovoid::experiments {

namespace {

// Cells reach this share of the sites' longest edge beyond them.
constexpr double kRoom = 0.1;
constexpr int kBlocks = 16;

}  // namespace

std::vector<double> natural_neighbor_values(std::span<const double> sites,
                                            std::span<const double> values,
                                            std::span<const double> places) {
  Bounds3 bounds;
  for (std::size_t i = 0; i < values.size(); ++i)
    bounds.extend(Vec3(sites[3 * i], sites[3 * i + 1], sites[3 * i + 2]));
  const Vec3 margin = Vec3::Constant(kRoom * bounds.sizes().maxCoeff());
  const Vec3 lo = bounds.min() - margin, hi = bounds.max() + margin;
  voro::container box(lo[0], hi[0], lo[1], hi[1], lo[2], hi[2], kBlocks, kBlocks, kBlocks, false,
                      false, false, 8);
  voro::particle_order order(static_cast<int>(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i)
    box.put(order, static_cast<int>(i), sites[3 * i], sites[3 * i + 1], sites[3 * i + 2]);
  voro::voronoicell_neighbor own;
  voro::voronoicell cell;
  std::vector<int> neighbors;
  std::vector<double> results;
  for (std::size_t p = 0; p + 2 < places.size(); p += 3) {
    const Vec3 at(places[p], places[p + 1], places[p + 2]);
    double sum = 0, taken = 0;
    if (box.compute_ghost_cell(own, at[0], at[1], at[2])) {
      own.neighbors(neighbors);
      for (const int n : neighbors) {
        if (n < 0) continue;
        const auto site = static_cast<std::size_t>(n);
        box.compute_cell(cell, order.o[2 * n], order.o[2 * n + 1]);
        const double before = cell.volume();
        const Vec3 to = at - Vec3(sites[3 * site], sites[3 * site + 1], sites[3 * site + 2]);
        const bool is_left = cell.plane(to[0], to[1], to[2]);
        const double share = before - (is_left ? cell.volume() : 0);
        sum += share * values[site];
        taken += share;
      }
    }
    results.push_back(taken > 0 ? sum / taken : 0);
  }
  return results;
}

}  // namespace ovoid::experiments
