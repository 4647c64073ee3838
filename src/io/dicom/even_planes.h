// SPDX-License-Identifier: Apache-2.0
// Planes of a lattice for slices that lie at uneven distances.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace ovoid::io {

struct EvenPlanes {
  static constexpr std::int64_t kLeftOut = -1;

  std::vector<std::int64_t> planes;  // of each height, from 0; kLeftOut: a nearer one has its plane
  double distance = 0;               // of planes
  double worst = 0;                  // the greatest distance of a height from its plane
  bool is_usual = false;             // `distance` is that of most neighbours, or of the nearest

  std::int64_t count() const { return planes.back() + 1; }
};

// Finds evenly spaced planes for heights that rise, at least two. The distance is the usual one of
// neighbours if all heights lie within `tolerance` distances of a plane, some of which may then be
// empty. Else it is the least distance of neighbours divided by the least whole number for which
// that is so. Where there would be more than 256 planes, and more than four for each height, there
// are no more than that, and heights lie where they lie; there are always as many as the least
// distance needs, up to 1024 or eight for each height. The first and the last height have planes.
EvenPlanes find_even_planes(std::span<const double> heights, double tolerance);

}  // namespace ovoid::io
