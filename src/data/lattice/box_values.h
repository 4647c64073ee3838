// SPDX-License-Identifier: Apache-2.0
// The values of a box of samples that rise evenly, in steps above the least: one formula for those
// who choose boxes and those who read them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "ovoid/lattice_boxes.h"

namespace ovoid::data {

class BoxValues {
 public:
  explicit BoxValues(const LatticeBox& box) : first_(box.first) {
    for (std::size_t a = 0; a < 3; ++a)
      slope_[a] = box.size[a] > 1 ? static_cast<double>(box.rise[a]) / (box.size[a] - 1) : 0.0;
  }

  // Of row (j, k) of the box, sample i is row() + i * slope().
  double row(std::int64_t j, std::int64_t k) const {
    return first_ + static_cast<double>(j) * slope_[1] + static_cast<double>(k) * slope_[2];
  }
  double slope() const { return slope_[0]; }

 private:
  double first_;
  double slope_[3];
};

// What is read for such a value.
class SampleOfBox {
 public:
  explicit SampleOfBox(const LatticeBoxes& all)
      : least_(all.least), greatest_(all.greatest), step_(all.step), whole_(all.whole) {}

  float operator()(double steps) const {
    return static_cast<float>(std::clamp(rounded(steps), least_, greatest_));
  }
  float unclamped(double steps) const { return static_cast<float>(rounded(steps)); }

 private:
  double rounded(double steps) const {
    const double value = least_ + step_ * steps;
    return whole_ ? std::floor(value + 0.5) : value;
  }

  double least_, greatest_, step_;
  bool whole_;
};

}  // namespace ovoid::data
