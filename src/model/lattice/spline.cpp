// SPDX-License-Identifier: Apache-2.0
#include "model/lattice/spline.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace ovoid::model {
namespace {

const double kPole = std::sqrt(3.0) - 2.0;
constexpr std::int64_t kPoleReach = 20;  // samples: pole^20 = 4e-12

// The place in [0, length) at which a mirrored line has what it has at `index`.
std::int64_t mirrored(std::int64_t index, std::int64_t length) {
  if (length == 1) return 0;
  const std::int64_t period = 2 * (length - 1);
  const std::int64_t within = ((index % period) + period) % period;
  return std::min(within, period - within);
}

}  // namespace

void to_spline_coefficients(std::span<double> line) {
  const auto length = static_cast<std::int64_t>(line.size());
  if (length < 2) return;
  double start = 0;
  double power = 1;
  for (std::int64_t i = 0; i < kPoleReach; ++i) {
    start += power * line[static_cast<std::size_t>(mirrored(i, length))];
    power *= kPole;
  }
  line[0] = start;
  for (std::size_t i = 1; i < line.size(); ++i) line[i] += kPole * line[i - 1];
  const std::size_t last = line.size() - 1;
  line[last] = kPole / (kPole * kPole - 1) * (line[last] + kPole * line[last - 1]);
  for (std::size_t i = last; i-- > 0;) line[i] = kPole * (line[i + 1] - line[i]);
  for (double& c : line) c *= 6;
}

SplineTaps::SplineTaps(std::int64_t length, std::span<const double> positions) {
  taps_.reserve(positions.size());
  for (const double position : positions) {
    const double whole = std::floor(position);
    const double f = position - whole;
    const double g = 1 - f;
    Tap tap{{g * g * g / 6, 2.0 / 3 - f * f * (1 + g) / 2, 2.0 / 3 - g * g * (1 + f) / 2,
             f * f * f / 6},
            {}};
    for (std::int64_t k = 0; k < 4; ++k)
      tap.index[k] = mirrored(static_cast<std::int64_t>(whole) + k - 1, length);
    taps_.push_back(tap);
  }
}

}  // namespace ovoid::model
