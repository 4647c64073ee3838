// SPDX-License-Identifier: Apache-2.0
#include "experiments/site_shapes.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "model/lattice/noise.h"
#include "model/mesh/amplitudes.h"
#include "model/mesh/ellipsoid_shape.h"
#include "model/mesh/voronoi_sites.h"
#include "model/particles/kernel_parts.h"
#include "ovoid/fit.h"

namespace ovoid::experiments {

namespace {

using model::VoronoiCell;

constexpr double kCutoff = 4;
constexpr double kRidge = 0.05;
constexpr int kPlaces = 20000;
constexpr double kFirstInside = 0.2, kInside = 0.6;

using Six = Eigen::Matrix<double, 6, 1>;

// d^T B d = row . (xx, yy, zz, xy, xz, yz of B).
Six row_of(const Vec3& d) {
  return {d[0] * d[0], d[1] * d[1], d[2] * d[2], 2 * d[0] * d[1], 2 * d[0] * d[2], 2 * d[1] * d[2]};
}

Mat3 matrix_of(const Six& b) {
  Mat3 matrix;
  matrix << b[0], b[3], b[4], b[3], b[1], b[5], b[4], b[5], b[2];
  return matrix;
}

bool is_ellipsoid(const Mat3& matrix) {
  return matrix.allFinite() && Eigen::SelfAdjointEigenSolver<Mat3>(matrix).eigenvalues()[0] > 1e-6;
}

// The B of least squares, in coordinates in which the covariance by PCA is 1: there the ridge is a
// number, whatever the cell's form.
Mat3 least_squares(const VoronoiCell& cell, const Mat3& factor, double ridge) {
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  Six right = Six::Zero();
  const double sum = std::accumulate(cell.shares.begin(), cell.shares.end(), 0.0);
  for (std::size_t f = 0; f < cell.feet.size(); ++f) {
    const Six row = row_of(factor.triangularView<Eigen::Lower>().solve(cell.feet[f]));
    normal += cell.shares[f] / sum * row * row.transpose();
    right += cell.shares[f] / sum * row;
  }
  // |B - 1|^2 counts what is off the diagonal twice.
  Six counts;
  counts << 1, 1, 1, 2, 2, 2;
  normal += (ridge * counts).asDiagonal();
  right.head<3>().array() += ridge;
  return matrix_of(normal.ldlt().solve(right));
}

bool is_scaled(SiteShape shape) {
  return shape == SiteShape::kScaledPca || shape == SiteShape::kScaledRidge;
}

// The factor of a cell's covariance; whether least squares had one of its own.
Mat3 factor_of_cell(const VoronoiCell& cell, SiteShape shape, bool& is_own) {
  Mat3 pca = model::shape_of_covariance(model::spread_of(cell)).factor;
  if (shape == SiteShape::kPca || shape == SiteShape::kScaledPca) return pca;
  // A little is needed to solve it at all where bisectors are few.
  const double ridge = shape == SiteShape::kLeastSquares ? 1e-12 : kRidge;
  const Mat3 b = least_squares(cell, pca, ridge);
  is_own = is_ellipsoid(b);
  if (!is_own) return pca;
  return model::shape_of_covariance(pca * b.inverse() * pca.transpose()).factor;
}

double axis_ratio(const Mat3& factor) {
  const Vec3 squares =
      Eigen::SelfAdjointEigenSolver<Mat3>(factor * factor.transpose()).eigenvalues();
  return std::sqrt(squares[2] / squares[0]);
}

}  // namespace

Sites jittered_sites(int side, double most, std::uint64_t seed) {
  Sites sites;
  sites.name = "jittered";
  model::Random random(seed);
  for (int k = 0; k < side; ++k) {
    for (int j = 0; j < side; ++j) {
      for (int i = 0; i < side; ++i) {
        for (const int at : {i, j, k}) sites.at.push_back(at + random.uniform(-most, most));
      }
    }
  }
  sites.inside = [side](const Vec3& u) {
    return Vec3((kFirstInside + kInside * u.array()) * (side - 1));
  };
  return sites;
}

Sites c_grid_sites() {
  // Of indices from 0 to 1: round, away from the fin, and up.
  const auto place = [](const Vec3& u) {
    const double angle = std::numbers::pi * (u[0] - 0.5);
    const double away = 0.5 + 4 * std::expm1(2.5 * u[1]) / std::expm1(2.5);
    return Vec3(away * std::cos(angle), away * std::sin(angle),
                3 * std::expm1(3 * u[2]) / std::expm1(3));
  };
  const std::array<int, 3> counts = {40, 32, 32};
  Sites sites;
  sites.name = "C-grid";
  for (int k = 0; k < counts[2]; ++k) {
    for (int j = 0; j < counts[1]; ++j) {
      for (int i = 0; i < counts[0]; ++i) {
        const Vec3 at = place(Vec3(i / 39.0, j / 31.0, k / 31.0));
        sites.at.insert(sites.at.end(), {at[0], at[1], at[2]});
      }
    }
  }
  sites.inside = [place](const Vec3& u) { return place((kFirstInside + kInside * u.array())); };
  return sites;
}

const char* name_of(SiteShape shape) {
  switch (shape) {
    case SiteShape::kPca:
      return "PCA";
    case SiteShape::kLeastSquares:
      return "least squares, else PCA";
    case SiteShape::kRidge:
      return "ridge least squares";
    case SiteShape::kScaledPca:
      return "PCA of the cell's volume (Ovoid)";
    case SiteShape::kScaledRidge:
      return "ridge, of the cell's volume";
  }
  return "";
}

KernelColumns SiteKernels::columns() const {
  KernelColumns columns;
  columns.shape = KernelShape::kEllipsoids;
  columns.cutoff = kCutoff;
  columns.centers = centers;
  columns.shapes = shapes;
  columns.weights = weights;
  return columns;
}

SiteKernels kernels_of_sites(const Sites& sites, SiteShape shape) {
  SiteKernels kernels;
  std::vector<Mat3> factors(sites.count(), Mat3::Identity());
  std::vector<double> weights(sites.count());
  double own = 0;
  model::visit_voronoi_cells(
      sites.at,
      [&](std::uint32_t site, const VoronoiCell& cell) {
        bool is_own = true;
        Mat3 factor = factor_of_cell(cell, shape, is_own);
        own += is_own ? 1 : 0;
        if (is_scaled(shape)) {
          factor = model::kernel_of_volume({factor}, cell.volume).factor;
        }
        factors[site] = factor;
        weights[site] = cell.volume / (std::pow(2 * std::numbers::pi, 1.5) * factor.determinant());
        kernels.ratios.push_back(axis_ratio(factor));
      },
      {});
  kernels.ellipsoid_share = own / static_cast<double>(sites.count());
  std::sort(kernels.ratios.begin(), kernels.ratios.end());
  kernels.centers = sites.at;
  for (const Mat3& factor : factors) model::append_factor(factor, kernels.shapes);
  kernels.weights.assign(weights.begin(), weights.end());
  return kernels;
}

SiteKernels with_passes(SiteKernels kernels, int passes) {
  const std::vector<float> targets(kernels.weights.size(), 1.0F);
  model::fit_amplitudes({kernels.centers, kernels.shapes, targets, kCutoff, passes},
                        kernels.weights);
  return kernels;
}

Unity measure_unity(const Sites& sites, const SiteKernels& kernels) {
  model::Random random(3);
  std::vector<double> places;
  for (int i = 0; i < kPlaces; ++i) {
    Vec3 u;
    for (double& x : u) x = random.uniform(0, 1);
    const Vec3 at = sites.inside(u);
    places.insert(places.end(), {at[0], at[1], at[2]});
  }
  const KernelOperator sums(kernels.columns(), Reconstruction::kSum, places);
  double sum = 0, squares = 0;
  for (const float weight : sums.weights()) {
    sum += static_cast<double>(weight);
    squares += static_cast<double>(weight) * static_cast<double>(weight);
  }
  const double mean = sum / kPlaces;
  return {mean, std::sqrt(std::max(0.0, squares / kPlaces - mean * mean)) / mean};
}

}  // namespace ovoid::experiments
