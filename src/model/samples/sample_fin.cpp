// SPDX-License-Identifier: Apache-2.0
//
// A fin with a round leading edge (radius 1, along z) stands on a plate (z = 0); the flow comes
// along +x. The grid wraps around it like a C: i along the body, j away from it, k up the fin,
// cells growing away from the walls by a ratio as flow solvers use. The fields are formulas with
// the features of such a flow: a bow shock, the boundary layers of both walls and the vortex that
// the plate's bends around the foot of the fin.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "data/cell_builder.h"
#include "model/lattice/noise.h"
#include "model/own_array.h"
#include "model/samples/sample_sets.h"

namespace ovoid::model {

namespace {

using std::numbers::pi;

constexpr double kFinLength = 3;  // of the straight sides behind the leading edge
constexpr double kFinReach = 4;   // from the fin's wall to the grid's end
constexpr double kFinHeight = 5;
constexpr double kFinGrowth = 3.5;  // of the exponential spacing, from wall to end e^3.5 = 33 times
constexpr double kFinShake = 0.1;   // of the distance to the next node

// Where along [0, 1] node i of n lies: crowded near 0.
double crowded(double share) { return std::expm1(kFinGrowth * share) / std::expm1(kFinGrowth); }

// Place at share `along` of the body's outline (0 and 1: its ends), `away` from it.
Vec3 place_in_c(double along, double away) {
  const double length = 2 * kFinLength + pi;
  const double s = (along - 0.5) * length;
  const double side = s < 0 ? -1 : 1;
  if (std::abs(s) <= pi / 2) return {-std::cos(s) * (1 + away), std::sin(s) * (1 + away), 0};
  const double back = std::abs(s) - pi / 2;
  // Lines fan out a little behind the leading edge, as a C-grid's do.
  return {back * (1 + 0.15 * away), side * (1 + away * (1 + 0.05 * back)), 0};
}

// Smooth step from 0 to 1 around 0, about `width` wide.
double smooth_rise(double x, double width) { return 0.5 * (1 + std::tanh(2 * x / width)); }

struct FlowValues {
  double density, pressure;
};

FlowValues flow_at(const Vec3& p) {
  const double ahead = std::min(p.x(), 0.0);
  const double wall = std::max(std::hypot(ahead, p.y()) - 1, 0.0);  // distance from the fin
  const double turn = std::atan2(std::abs(p.y()), -p.x());          // 0 on the stagnation line
  const double stand_off = 0.9 + 0.75 * turn * turn;
  const double foot = std::exp(-p.z() * p.z() / 0.5);
  const double shock = smooth_rise(stand_off * (1 + 0.7 * foot) - wall, 0.25);
  const double facing = std::pow(std::max(std::cos(0.5 * turn), 0.0), 4);
  double pressure = 1 + shock * (1.5 + 6 * facing * std::exp(-0.8 * wall));
  double density = 1 + shock * (1 + 2.5 * facing * std::exp(-0.6 * wall));
  density *= 1 - 0.45 * std::exp(-wall / 0.12);
  density *= 1 - 0.5 * std::exp(-p.z() / 0.25);
  const double core = std::hypot(wall - 0.55, p.z() - 0.4);
  const double vortex = std::exp(-core * core / 0.05) * std::exp(-0.3 * turn * turn);
  pressure *= 1 - 0.5 * vortex;
  density *= 1 - 0.4 * vortex;
  return {density, pressure};
}

// Six tetrahedra around the diagonal of a box: one for each order of the axes.
Cells cut_boxes(const Index3& dims) {
  constexpr std::array<std::array<int, 3>, 6> kOrders = {
      {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}}};
  const std::array<std::int64_t, 3> stride = {1, dims[0], dims[0] * dims[1]};
  data::CellBuilder cells;
  for (std::int64_t k = 0; k + 1 < dims[2]; ++k) {
    for (std::int64_t j = 0; j + 1 < dims[1]; ++j) {
      for (std::int64_t i = 0; i + 1 < dims[0]; ++i) {
        for (std::size_t o = 0; o < kOrders.size(); ++o) {
          std::int64_t node = i + j * stride[1] + k * stride[2];
          std::array<std::uint32_t, 4> corners{};
          corners[0] = static_cast<std::uint32_t>(node);
          for (std::size_t c = 0; c < 3; ++c) {
            node += stride[static_cast<std::size_t>(kOrders[o][c])];
            corners[c + 1] = static_cast<std::uint32_t>(node);
          }
          if (o < 3) std::swap(corners[1], corners[2]);  // even orders: i, j, k run left-handed
          cells.add(CellType::kTetrahedron, corners);
        }
      }
    }
  }
  return std::move(cells).finish();
}

}  // namespace

Dataset make_fin(std::int64_t count, std::uint64_t seed) {
  const double side = std::cbrt(static_cast<double>(std::max(count, kLeastFinNodes)) * 0.8);
  const Index3 dims = {std::max<std::int64_t>(std::llround(1.25 * side), 3),
                       std::max<std::int64_t>(std::llround(side), 3),
                       std::max<std::int64_t>(std::llround(side), 3)};
  Random random(seed);
  std::vector<double> positions;
  std::vector<float> density, pressure;
  const auto place = [&](double i, double j, double k) {
    Vec3 at = place_in_c(i / static_cast<double>(dims[0] - 1),
                         kFinReach * crowded(j / static_cast<double>(dims[1] - 1)));
    at.z() = kFinHeight * crowded(k / static_cast<double>(dims[2] - 1));
    return at;
  };
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i) {
        Vec3 index(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
        const Index3 at = {i, j, k};
        for (int axis = 0; axis < 3; ++axis) {  // walls and ends stay where they are
          const double shake = random.uniform(-kFinShake, kFinShake);
          if (at[axis] > 0 && at[axis] + 1 < dims[axis]) index[axis] += shake;
        }
        const Vec3 p = place(index[0], index[1], index[2]);
        positions.insert(positions.end(), {p[0], p[1], p[2]});
        const FlowValues flow = flow_at(p);
        density.push_back(static_cast<float>(flow.density));
        pressure.push_back(static_cast<float>(flow.pressure));
      }
    }
  }
  Dataset dataset;
  dataset.kind = DatasetKind::kMesh;
  dataset.positions = array_of_numbers("positions", 3, std::move(positions));
  dataset.arrays.push_back(array_of_numbers("density", 1, std::move(density)));
  dataset.arrays.push_back(array_of_numbers("pressure", 1, std::move(pressure)));
  dataset.cells = cut_boxes(dims);
  return dataset;
}

}  // namespace ovoid::model
