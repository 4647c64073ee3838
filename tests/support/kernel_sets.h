// SPDX-License-Identifier: Apache-2.0
// Kernel sets for tests: each with something that a back end could get wrong.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "ovoid/kernel_field.h"

namespace ovoid::test {

// Columns that own their numbers.
struct KernelNumbers {
  KernelShape shape = KernelShape::kEllipsoids;
  KernelProfile profile = KernelProfile::kGaussian;
  double cutoff = 4;
  std::vector<double> centers;
  std::vector<float> shapes, weights;
  std::vector<std::vector<float>> values;

  std::shared_ptr<const KernelSource> source() const;
  // Adds an ellipsoid with these half-axes (sigmas), turned, that stands for its cell's volume.
  void add(const Vec3& center, const Vec3& sigmas, const Mat3& rotation, std::vector<float> of);
};

// Jittered cells of a unit cube, `edge` along each axis, whose kernels fit them: neighbours' sizes
// and directions differ. Values: a smooth function in [0, 1], and another one.
KernelNumbers jittered_ellipsoids(int edge, double stretch = 1.5);
KernelNumbers jittered_balls(int edge);
// Balls with sigmas from `least` to a tenth of the unit cube.
KernelNumbers balls_of_all_sizes(int count, double least);
// A lattice's own balls: `edge`^3 samples with spacing 1 and the cut-off given.
KernelNumbers lattice_balls(int edge, double cutoff);

Mat3 some_rotation(int number);

}  // namespace ovoid::test
