// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/math.h"

namespace ovoid::model {

// A covariance's least axis is at least this share of its greatest, in sigmas: a stretched mesh
// keeps ratios of 1:1000 and more.
inline constexpr double kLeastAxisRatio = 1e-4;
// What has no thickness of its own, a surface or a line, gets this share of its next axis: a disc
// or a rod that can still be seen edge on.
inline constexpr double kFlatAxisRatio = 0.05;

// A kernel's shape as it is stored.
struct EllipsoidShape {
  Mat3 factor = Mat3::Identity();  // lower triangular, L L^T = S, diagonal > 0
  int rank = 3;                    // axes that had a length of their own
  bool is_degenerate = false;      // some had to be given one
};

// Whether a covariance comes from what fills space, or from surfaces and lines.
enum class Extent3 { kSolid, kFlat };

// The factor of a finite covariance that may be singular or, by rounding, slightly indefinite. Thin
// axes are made thicker as the constants above say. rank 0: the covariance is 0, and the factor the
// identity.
EllipsoidShape shape_of_covariance(const Mat3& covariance, Extent3 extent = Extent3::kSolid);

// The lower triangular L, diagonal > 0, with L L^T = V diag(axes^2) V^T for an orthogonal V.
Mat3 factor_of_axes(const Mat3& vectors, const Vec3& axes);

// The shape of a covariance with axes under `least_ratio` of the longest made that long.
EllipsoidShape limited_shape(const Mat3& covariance, double least_ratio);

// Shape and weight that a site's surroundings give its kernel.
struct SiteKernel {
  Mat3 factor = Mat3::Identity();
  double weight = 1;  // what makes the sum of weights about `target`
  double target = 1;  // the sum of weights at the site: 1 inside, less at the end of the data
  bool is_degenerate = false;
  bool is_alone = false;     // no neighbours: the shape is not known
  bool is_dangling = false;  // of no cell
};

// The kernel of a site that stands for `volume` and whose neighbours give `shape`: the shape is
// scaled so that det L = V / 8, as in a lattice of cells V where sigma is half the spacing. It is
// scaled by kLeastScale to kMostScale only: what is beyond is a defect (slivers, cells inside out,
// open Voronoi cells), and following it would leave holes or blur.
SiteKernel kernel_of_volume(const EllipsoidShape& shape, double volume);
inline constexpr double kLeastScale = 0.5;
inline constexpr double kMostScale = 1.5;

// w = V / ((2 pi)^(3/2) det L) with det L = V / 8.
inline constexpr double kLatticeWeight = 0.5079490874739278;

}  // namespace ovoid::model
