// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/software_limits.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace ovoid::vulkan {

double rounds_of_sample(const LatticeLoops& loops, const device::LatticeConstants& lattice) {
  const double taps = std::floor(2 * static_cast<double>(lattice.support) * loops.widening) + 1;
  const bool has_four_taps = (loops.flags & device::kHasFourTaps) != 0 && loops.widening == 1 &&
                             (loops.flags & device::kMayMiss) == 0;
  // A row of taps goes by fours.
  const double per_point =
      has_four_taps ? 30 : taps * (taps * (std::ceil(taps / 4) + 1) + 1) + 9 * taps;
  const bool is_surface = loops.mode == Mode::kIsosurface;
  // Of a refined piece both ends may have to be worked out with their gradients.
  const double ends = loops.is_refined ? 2 : 1;
  const double samples =
      is_surface ? device::kSurfaceSteps + 3 : ends * (loops.takes_differences ? 8 : 2);
  const double steps = loops.is_refined ? device::kMostSteps : 0;
  return samples * per_point * lattice.num_slab_points * loops.num_sublattices + steps;
}

// A stop is passed, looked at for paths, and begins a part of a piece in so many steps. As pixels
// that are drawn together pass their stops at different sheets, theirs add up.
double rounds_of_stops(const DepthLimits& limits) {
  constexpr double kPixelsTogether = 16;  // numbers in the widest registers
  std::uint32_t most = 0;
  for (std::size_t i = 1; i < limits.first.size(); ++i)
    most = std::max(most, limits.first[i] - limits.first[i - 1]);
  return kPixelsTogether * most * (device::kMostSteps + 3);
}

double rounds_of_spread(const device::LatticeConstants& lattice, double apart) {
  double rounds = 2;
  const device::vec4& along = lattice.camera_rows[2];
  const double tau = static_cast<double>(lattice.sigma) * std::hypot(along.x, along.y, along.z);
  const double reach = static_cast<double>(lattice.support / lattice.sigma) * tau;
  for (const device::vec4& row : lattice.camera_columns)
    rounds *=
        2 * (static_cast<double>(row.x + row.y) * apart + static_cast<double>(row.z) * reach) + 2;
  return rounds;
}

}  // namespace ovoid::vulkan
