// SPDX-License-Identifier: Apache-2.0
// Cells are measured once, then every node gathers from the cells around it: no two threads write
// to one place, and the order of sums is that of the cells.
#include "model/mesh/mesh_ellipsoids.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "data/parallel.h"
#include "model/mesh/ellipsoid_shape.h"

namespace ovoid::model {

namespace {

// A cell's corner at a node.
struct Corner {
  std::uint32_t cell = 0;
  std::uint32_t local = 0;
};

// The corners at each node (those that others stand for: none).
struct Incidence {
  std::vector<std::size_t> firsts;  // [num_nodes + 1]
  std::vector<Corner> corners;
};

Incidence find_corners(const MeshNodes& nodes, const MeshCells& cells) {
  Incidence incidence;
  incidence.firsts.assign(nodes.count() + 1, 0);
  for (const std::uint32_t node : cells.connectivity)
    ++incidence.firsts[nodes.stands_for(node) + 1];
  std::partial_sum(incidence.firsts.begin(), incidence.firsts.end(), incidence.firsts.begin());
  std::vector<std::size_t> next(incidence.firsts.begin(), incidence.firsts.end() - 1);
  incidence.corners.resize(cells.connectivity.size());
  for (std::size_t c = 0; c < cells.count(); ++c) {
    const auto list = cells.nodes(c);
    for (std::size_t k = 0; k < list.size(); ++k)
      incidence.corners[next[nodes.stands_for(list[k])]++] = {static_cast<std::uint32_t>(c),
                                                              static_cast<std::uint32_t>(k)};
  }
  return incidence;
}

// Solid angle of the triangle that three unit vectors span, signed [Oosterom 1983].
double solid_angle(const Vec3& a, const Vec3& b, const Vec3& c) noexcept {
  return 2 * std::atan2(a.dot(b.cross(c)), 1 + a.dot(b) + b.dot(c) + c.dot(a));
}

// Sums over the corners at a node.
class NodeSums {
 public:
  NodeSums(const MeshNodes& nodes, const MeshCells& cells, const CellMeasures& measures,
           std::uint32_t node)
      : nodes_(nodes), cells_(cells), measures_(measures), place_(nodes.at(node)) {}

  void add(const Corner& corner) {
    if (!measures_.is_placed(corner.cell)) return;
    const double volume = std::abs(measures_.volumes[corner.cell]);
    has_cell_ = true;
    if (table_of(cells_.types[corner.cell]).has_any_nodes()) {
      add_other(corner, volume);
    } else {
      add_known(corner, volume);
    }
  }

  SiteKernel kernel() const {
    SiteKernel kernel;
    if (weight_ > 0 && volume_ > 0) {
      const double full = 4 * std::numbers::pi;
      const double filled =
          is_angle_known_ ? std::clamp(std::abs(angle_) / full, kLeastAngle, 1.0) : 1.0;
      kernel = kernel_of_volume(shape_of_covariance(3 / weight_ * spread_), volume_ / filled);
      kernel.target = std::max(filled, kLeastShare);
      kernel.weight *= kernel.target;
      return kernel;
    }
    if (flat_weight_ > 0) {
      // Its neighbours span only so many axes, among which the sum of squares is shared.
      const EllipsoidShape shape = shape_of_covariance(flat_spread_ / flat_weight_, Extent3::kFlat);
      kernel.factor = shape.factor * std::sqrt(static_cast<double>(std::max(shape.rank, 1)));
      kernel.is_degenerate = true;
      kernel.is_alone = shape.rank == 0;
    } else {
      kernel.is_alone = true;
    }
    kernel.weight = kLatticeWeight;
    kernel.is_dangling = !has_cell_;
    return kernel;
  }

 private:
  // A share of the solid angle under this is a spike; its volume says nothing.
  static constexpr double kLeastAngle = 0.02;

  Vec3 ray_to(std::uint32_t node) const noexcept { return nodes_.at(node) - place_; }

  static void add_bisector(Mat3& spread, const Vec3& ray, double weight) noexcept {
    spread.noalias() += (0.25 * weight) * ray * ray.transpose();
  }

  void add_known(const Corner& corner, double volume) {
    const auto list = cells_.nodes(corner.cell);
    const CellTable& table = table_of(cells_.types[corner.cell]);
    const double corners = static_cast<double>(list.size());
    volume_ += volume / corners;
    const double weight = 2 * volume / corners;
    std::array<Vec3, 8> unit;
    std::size_t count = 0;
    for (const std::uint8_t neighbor : table.neighbors[corner.local]) {
      const Vec3 ray = ray_to(list[neighbor]);
      const double length = ray.norm();
      if (!(length > 0)) {  // a collapsed edge; the solid angle is not the fan's
        is_angle_known_ = is_angle_known_ && table.dimension < 3;
        continue;
      }
      weight_ += weight;
      add_bisector(spread_, ray, weight);
      add_flat(ray);
      if (count < unit.size()) unit[count++] = ray / length;
    }
    if (table.dimension < 3) return;
    if (table.fans[corner.local].empty()) is_angle_known_ = false;
    double angle = 0;
    for (std::size_t r = 2; r < count; ++r) angle += solid_angle(unit[0], unit[r - 1], unit[r]);
    angle_ += std::abs(angle);
  }

  // All nodes of the cell are neighbours: sum (x - p)(x - p)^T over them, from their moments.
  void add_other(const Corner& corner, double volume) {
    const auto list = cells_.nodes(corner.cell);
    if (list.size() < 2) return;
    const CellMoments& moments = measures_.moments_of_other(corner.cell);
    const Vec3 ray = moments.mean - place_;
    const Mat3 spread = 0.25 * (moments.covariance + ray * ray.transpose());
    const double weight = 6 * volume / static_cast<double>(list.size());
    volume_ += volume / static_cast<double>(list.size());
    spread_ += weight * spread;
    weight_ += weight;
    flat_spread_ += spread;
    flat_weight_ += 1;
    if (volume > 0) is_angle_known_ = false;
  }

  void add_flat(const Vec3& ray) noexcept {
    add_bisector(flat_spread_, ray, 1);
    flat_weight_ += 1;
  }

  const MeshNodes& nodes_;
  const MeshCells& cells_;
  const CellMeasures& measures_;
  Vec3 place_;
  Mat3 spread_ = Mat3::Zero(), flat_spread_ = Mat3::Zero();
  double weight_ = 0, flat_weight_ = 0, volume_ = 0, angle_ = 0;
  bool is_angle_known_ = true;
  bool has_cell_ = false;
};

}  // namespace

std::vector<SiteKernel> node_kernels(const ModelRun& run, const MeshNodes& nodes,
                                     const MeshCells& cells, const CellMeasures& measures) {
  const Incidence incidence = find_corners(nodes, cells);
  std::vector<SiteKernel> kernels(nodes.count());
  data::parallel_ranges(
      {static_cast<std::int64_t>(nodes.count()), kSiteGrain, run.threads, run.stop},
      [&](std::int64_t begin, std::int64_t end) {
        for (auto n = static_cast<std::size_t>(begin); n < static_cast<std::size_t>(end); ++n) {
          const auto node = static_cast<std::uint32_t>(n);
          if (nodes.stands_for(node) != node || !nodes.is_placed(node)) continue;
          NodeSums sums(nodes, cells, measures, node);
          for (std::size_t k = incidence.firsts[n]; k < incidence.firsts[n + 1]; ++k)
            sums.add(incidence.corners[k]);
          kernels[n] = sums.kernel();
        }
      });
  return kernels;
}

SiteKernel cell_kernel(const CellMoments& moments, double volume) {
  if (volume > 0) return kernel_of_volume(shape_of_covariance(moments.covariance), volume);
  SiteKernel kernel;
  const EllipsoidShape shape = shape_of_covariance(moments.covariance, Extent3::kFlat);
  kernel.factor = shape.factor;
  kernel.weight = kLatticeWeight;
  kernel.is_degenerate = true;
  kernel.is_alone = shape.rank == 0;
  return kernel;
}

}  // namespace ovoid::model
