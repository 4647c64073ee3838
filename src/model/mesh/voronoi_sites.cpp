// SPDX-License-Identifier: Apache-2.0
#include "model/mesh/voronoi_sites.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <voro++/voro++.hh>

#include "ovoid/error.h"

namespace ovoid::model {

namespace {

constexpr double kMargin = 1e-3;      // of the longest edge, around the sites
constexpr double kSitesPerBlock = 5;  // what Voro++'s manual finds fastest
constexpr int kMostBlocks = 256;      // per axis
constexpr std::int64_t kStopEvery = 1024;

// Sites in a box of longest edge 1 from the origin, so that Voro++'s tolerances, which are
// absolute, mean the same for all data.
struct UnitSites {
  std::vector<Vec3> at;
  Vec3 box = Vec3::Ones();
  double edge = 1;  // world units per unit
};

UnitSites to_unit(std::span<const double> sites) {
  UnitSites unit;
  const std::size_t count = sites.size() / 3;
  Bounds3 bounds;
  for (std::size_t i = 0; i < count; ++i)
    bounds.extend(Vec3(sites[3 * i], sites[3 * i + 1], sites[3 * i + 2]));
  unit.edge = bounds.sizes().maxCoeff();
  if (!(unit.edge > 0)) unit.edge = 1;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 world(sites[3 * i], sites[3 * i + 1], sites[3 * i + 2]);
    unit.at.emplace_back((world - bounds.min()) / unit.edge + Vec3::Constant(kMargin));
  }
  unit.box = bounds.sizes() / unit.edge + Vec3::Constant(2 * kMargin);
  return unit;
}

// Sites at one place confuse the cells: the first stands for all.
std::vector<bool> find_firsts(const UnitSites& unit) {
  std::vector<std::uint32_t> order(unit.at.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto is_less = [&](std::uint32_t a, std::uint32_t b) {
    const Vec3 &p = unit.at[a], &q = unit.at[b];
    return p != q ? std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end()) : a < b;
  };
  std::sort(order.begin(), order.end(), is_less);
  std::vector<bool> is_first(order.size(), true);
  for (std::size_t i = 1; i < order.size(); ++i)
    is_first[order[i]] = unit.at[order[i]] != unit.at[order[i - 1]];
  return is_first;
}

VoronoiCell cell_of(const UnitSites& unit, std::uint32_t site, voro::voronoicell_neighbor& own) {
  std::vector<int> neighbors;
  std::vector<double> areas;
  own.neighbors(neighbors);
  own.face_areas(areas);
  VoronoiCell cell;
  for (std::size_t f = 0; f < neighbors.size(); ++f) {
    if (neighbors[f] < 0) {
      cell.is_open = true;
      continue;
    }
    const Vec3 foot = (unit.at[static_cast<std::size_t>(neighbors[f])] - unit.at[site]) / 2;
    cell.feet.emplace_back(unit.edge * foot);
    cell.shares.push_back(areas[f] * foot.norm());
  }
  cell.volume = own.volume() * std::pow(unit.edge, 3);
  return cell;
}

SiteKernel kernel_of_cell(const VoronoiCell& cell) {
  if (!(std::accumulate(cell.shares.begin(), cell.shares.end(), 0.0) > 0)) {
    SiteKernel alone;
    alone.is_alone = true;
    return alone;
  }
  return kernel_of_volume(shape_of_covariance(spread_of(cell)), cell.volume);
}

}  // namespace

Mat3 spread_of(const VoronoiCell& cell) {
  Mat3 spread = Mat3::Zero();
  double sum = 0;
  for (std::size_t f = 0; f < cell.feet.size(); ++f) {
    spread += cell.shares[f] * cell.feet[f] * cell.feet[f].transpose();
    sum += cell.shares[f];
  }
  return 3 / sum * spread;
}

void visit_voronoi_cells(std::span<const double> sites,
                         const std::function<void(std::uint32_t site, const VoronoiCell&)>& visit,
                         const std::stop_token& stop) {
  const UnitSites unit = to_unit(sites);
  const std::vector<bool> is_first = find_firsts(unit);
  const double blocks = std::max(1.0, static_cast<double>(unit.at.size()) / kSitesPerBlock);
  const double per_unit = std::cbrt(blocks / unit.box.prod());
  std::array<int, 3> grid{};
  for (int axis = 0; axis < 3; ++axis)
    grid[static_cast<std::size_t>(axis)] = static_cast<int>(
        std::clamp(unit.box[axis] * per_unit, 1.0, static_cast<double>(kMostBlocks)));
  voro::container box(0, unit.box[0], 0, unit.box[1], 0, unit.box[2], grid[0], grid[1], grid[2],
                      false, false, false, 8);
  for (std::size_t i = 0; i < unit.at.size(); ++i) {
    const Vec3& at = unit.at[i];
    if (is_first[i]) box.put(static_cast<int>(i), at[0], at[1], at[2]);
  }
  voro::c_loop_all loop(box);
  voro::voronoicell_neighbor cell;
  std::int64_t count = 0;
  if (!loop.start()) return;
  do {
    if (++count % kStopEvery == 0 && stop.stop_requested())
      throw Error(ErrorCode::kCancelled, "cancelled");
    const auto site = static_cast<std::uint32_t>(loop.pid());
    if (box.compute_cell(cell, loop)) visit(site, cell_of(unit, site, cell));
  } while (loop.inc());
}

std::vector<SiteKernel> voronoi_kernels(std::span<const double> sites,
                                        const std::stop_token& stop) {
  SiteKernel alone;
  alone.is_alone = true;
  std::vector<SiteKernel> kernels(sites.size() / 3, alone);
  visit_voronoi_cells(
      sites,
      [&](std::uint32_t site, const VoronoiCell& cell) { kernels[site] = kernel_of_cell(cell); },
      stop);
  return kernels;
}

}  // namespace ovoid::model
