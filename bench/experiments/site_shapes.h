// SPDX-License-Identifier: Apache-2.0
// Scattered sites, and the ellipsoids that their Voronoi cells give them [Hong 2009].
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "ovoid/kernel_field.h"

namespace ovoid::experiments {

struct Sites {
  std::string name;
  std::vector<double> at;  // [n, 3]
  // A place of the inner part, of three numbers in [0, 1].
  std::function<Vec3(const Vec3&)> inside;

  std::size_t count() const noexcept { return at.size() / 3; }
};

// side^3 sites at whole numbers, each moved by up to `most` along every axis; inside: the middle 60
// % along each axis.
Sites jittered_sites(int side, double most, std::uint64_t seed);
// 40 x 32 x 32 nodes round half a cylinder, finer towards it and towards its foot, as the grid of a
// flow along a blunt fin is; inside: the middle 60 % of the indices along each axis.
Sites c_grid_sites();

// How a cell's bisectors d with their shares s give A of exp(-d^T A d / 2).
enum class SiteShape {
  kPca,           // (3 sum s d d^T)^-1
  kLeastSquares,  // least sum s (d^T A d - 1)^2, where that is an ellipsoid, else as kPca
  kRidge,         // the same and 0.05 |B - 1|^2, B being A where kPca's is 1
  kScaledPca,     // kPca made as large as the cell: det A^-1/2 = V / 8; what Ovoid does
  kScaledRidge,   // kRidge likewise
};
inline constexpr SiteShape kSiteShapes[] = {SiteShape::kPca, SiteShape::kLeastSquares,
                                            SiteShape::kRidge, SiteShape::kScaledPca,
                                            SiteShape::kScaledRidge};
const char* name_of(SiteShape shape);

// Kernels of the sites; weights V / ((2 pi)^(3/2) det A^-1/2), which sum to about 1.
struct SiteKernels {
  std::vector<double> centers;  // [n, 3]
  std::vector<float> shapes;    // [n, 6]
  std::vector<float> weights;   // [n]
  double ellipsoid_share = 0;   // of the sites: whose own A is one
  std::vector<double> ratios;   // longest axis over shortest, rising

  KernelColumns columns() const;
};
SiteKernels kernels_of_sites(const Sites& sites, SiteShape shape);
// After `passes` of model::fit_amplitudes().
SiteKernels with_passes(SiteKernels kernels, int passes);

// The sum of weights at 20,000 random places inside: its mean, and its deviation over that.
struct Unity {
  double mean = 0, deviation = 0;
};
Unity measure_unity(const Sites& sites, const SiteKernels& kernels);

}  // namespace ovoid::experiments
