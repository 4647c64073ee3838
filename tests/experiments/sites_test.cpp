// SPDX-License-Identifier: Apache-2.0
// Kernels of scattered sites: shapes that are ellipsoids everywhere, sums of f = 1, and values that
// are fitted.
#include <gtest/gtest.h>

#include <cmath>

#include "experiments/natural_neighbors.h"
#include "experiments/site_fits.h"
#include "experiments/site_shapes.h"
#include "model/lattice/noise.h"
#include "support/where.h"

namespace ovoid::experiments {
namespace sites_test {

// Cells of a lattice have bisectors half a spacing long, which all shapes make sigma = 1/2 of.
// Least squares alone have too few of them: any product of two coordinates fits as well.
TEST(SiteShapes, OfALatticeAreThePublishedKernel) {
  const Sites sites = jittered_sites(7, 1e-9, 1);
  const std::size_t middle = 3 + 7 * (3 + 7 * 3);
  for (const SiteShape shape : kSiteShapes) {
    if (shape == SiteShape::kLeastSquares) continue;
    const SiteKernels kernels = kernels_of_sites(sites, shape);
    const float* const l = kernels.shapes.data() + 6 * middle;
    for (const std::size_t diagonal : {0, 2, 5}) EXPECT_NEAR(l[diagonal], 0.5, 1e-5);
    for (const std::size_t below : {1, 3, 4}) EXPECT_NEAR(l[below], 0, 1e-5);
    EXPECT_NEAR(kernels.weights[middle], 8 * std::pow(2 * std::acos(-1.0), -1.5), 1e-5);
  }
}

// Without a ridge some cells of scattered sites give no ellipsoid; with one every cell has its own,
// and f = 1 is kept to 7 % after three passes, better than by PCA.
TEST(SiteShapes, RidgeMakesEllipsoidsEverywhere) {
  OVOID_NOT_UNDER_ASAN();
  const Sites scattered = jittered_sites(14, 0.4, 1), grid = c_grid_sites();
  EXPECT_LT(kernels_of_sites(scattered, SiteShape::kLeastSquares).ellipsoid_share, 0.98);
  for (const Sites& sites : {scattered, grid}) {
    const SiteKernels kernels = kernels_of_sites(sites, SiteShape::kRidge);
    EXPECT_GT(kernels.ellipsoid_share, 0.99) << sites.name;
    const auto deviation = [&](SiteShape shape, int passes) {
      return measure_unity(sites, with_passes(kernels_of_sites(sites, shape), passes)).deviation;
    };
    EXPECT_NEAR(measure_unity(sites, kernels).mean, 1, 0.05) << sites.name;
    EXPECT_LT(deviation(SiteShape::kRidge, 3), 0.07) << sites.name;
    EXPECT_LT(deviation(SiteShape::kRidge, 3), deviation(SiteShape::kPca, 3)) << sites.name;
  }
}

// Fails if a neighbour is missed, or what is taken of its cell is wrong: natural neighbours are
// exact for linear functions. And at a site they give its value.
TEST(NaturalNeighbors, AreExactForLines) {
  const Sites sites = jittered_sites(8, 0.4, 2);
  const auto line = [](const Vec3& p) { return 2 + p[0] - 3 * p[1] + 0.5 * p[2]; };
  std::vector<double> values, places;
  for (std::size_t i = 0; i < sites.count(); ++i)
    values.push_back(line(Vec3(sites.at.data() + 3 * i)));
  model::Random random(3);
  for (int i = 0; i < 300; ++i) places.push_back(random.uniform(2, 5));
  const std::vector<double> found = natural_neighbor_values(sites.at, values, places);
  ASSERT_EQ(found.size(), 100U);
  for (std::size_t i = 0; i < found.size(); ++i)
    EXPECT_NEAR(found[i], line(Vec3(places.data() + 3 * i)), 1e-6);
}

TEST(SiteFits, FittedIsNearerThanNormalizedThanRaw) {
  const SiteErrors errors = measure_site_errors(franke_field(14), SiteShape::kScaledPca);
  EXPECT_LT(errors.fitted, 0.7 * errors.normalized);
  EXPECT_LT(errors.normalized, 0.7 * errors.raw);
}

// Sibson's values are nearer to the fit's end than Shepard's, where kernels were moved or merged.
TEST(SiteFits, BeginNearerWithNaturalNeighbors) {
  for (const Centers centers : {Centers::kMoved, Centers::kMerged}) {
    const auto found = [&](FirstValues first) {
      return measure_convergence(franke_field(12), centers, first, 4);
    };
    const Convergence sibson = found(FirstValues::kSibson),
                      shepard = found(FirstValues::kNormalized), mean = found(FirstValues::kMean);
    EXPECT_LT(sibson.errors[0], shepard.errors[0]) << name_of(centers);
    EXPECT_LT(shepard.errors[0], 0.7 * mean.errors[0]) << name_of(centers);
    EXPECT_LT(sibson.errors[4], 0.9 * sibson.errors[0]) << name_of(centers);
  }
}

}  // namespace sites_test
}  // namespace ovoid::experiments
