// SPDX-License-Identifier: Apache-2.0
// How steeply a lattice's samples rise, for telling surfaces from noise.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "ovoid/field.h"

namespace ovoid::data {

struct RiseSample {
  float value = 0;
  float around = 0;  // mean of the value and its six neighbours: less of the noise
  // By central differences, in values over the smallest spacing, along the lattice's own axes.
  Eigen::Vector3f gradient = Eigen::Vector3f::Zero();
  float agreement = 0;  // cosine between the gradient and the one of differences three times as
                        // wide, in [-1, 1]; 0 if one of the two is 0
};

// About kWantedRises samples, spread evenly over the lattice, those left out that have a missing
// neighbour. At the faces, and at those of what a source shows at once, differences are one-sided.
// The same field gives the same samples. Cost: thirteen reads a sample, some twenty milliseconds.
// Throws what the source throws.
inline constexpr std::int64_t kWantedRises = std::int64_t{1} << 17;
std::vector<RiseSample> take_rises(const BrickSource& source);
// The same, and never what a source has kept of them.
std::vector<RiseSample> find_rises(const BrickSource& source);

}  // namespace ovoid::data
