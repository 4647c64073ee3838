// SPDX-License-Identifier: Apache-2.0
#include "data/lattice/brick_reach.h"

#include <algorithm>
#include <cmath>

namespace ovoid::data {

SampleRange samples_in_brick(const LatticeGeometry& geometry, const Index3& brick,
                             int edge) noexcept {
  SampleRange range;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int64_t samples = edge * (a == 2 ? geometry.num_sublattices() : 1);
    range.lo[a] = brick[a] * samples;
    range.hi[a] = std::min(range.lo[a] + samples, geometry.dims[a]);
  }
  return range;
}

SampleRange samples_in_reach(const LatticeGeometry& geometry, const Index3& brick, int edge,
                             double reach) noexcept {
  SampleRange range;
  const bool is_cartesian = geometry.kind == LatticeKind::kCartesian;
  for (std::size_t a = 0; a < 3; ++a) {
    const double per_unit = a == 2 ? geometry.num_sublattices() : 1;
    // Samples of the second sublattice lie half a unit further.
    const double shift = is_cartesian || a == 2 ? 0.0 : 0.5;
    const auto size = static_cast<double>(geometry.dims[a]);
    const double lo = static_cast<double>(brick[a] * edge) - reach - shift;
    const double hi = static_cast<double>((brick[a] + 1) * edge) + reach;
    range.lo[a] = static_cast<std::int64_t>(std::clamp(std::ceil(lo * per_unit), 0.0, size - 1));
    range.hi[a] = static_cast<std::int64_t>(std::clamp(std::floor(hi * per_unit) + 1, 1.0, size));
  }
  return range;
}

}  // namespace ovoid::data
