// SPDX-License-Identifier: Apache-2.0
// Interpolation of a line of samples by cubic B-splines [Unser 1999].
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace ovoid::model {

// Replaces samples by the coefficients of the cubic B-splines that interpolate them; beyond its
// ends the line is mirrored in its first and last sample. In double, to 1e-9 of the greatest. Cost:
// two recursions.
void to_spline_coefficients(std::span<double> line);

// Places at which such a spline is wanted, and the weights of the coefficients around them.
class SplineTaps {
 public:
  // `length`: samples of the line, >= 1; `positions`: in samples from the first, finite, at most
  // two beyond either end.
  SplineTaps(std::int64_t length, std::span<const double> positions);

  std::size_t size() const noexcept { return taps_.size(); }
  double at(std::size_t place, std::span<const double> coefficients) const noexcept {
    const Tap& tap = taps_[place];
    double sum = 0;
    for (std::size_t k = 0; k < 4; ++k)
      sum += tap.weight[k] * coefficients[static_cast<std::size_t>(tap.index[k])];
    return sum;
  }
  // Adds the weight of every coefficient in the value at one place.
  void add_weights(std::size_t place, std::span<double> weights) const noexcept {
    const Tap& tap = taps_[place];
    for (std::size_t k = 0; k < 4; ++k)
      weights[static_cast<std::size_t>(tap.index[k])] += tap.weight[k];
  }

 private:
  struct Tap {
    double weight[4];
    std::int64_t index[4];
  };
  std::vector<Tap> taps_;
};

}  // namespace ovoid::model
