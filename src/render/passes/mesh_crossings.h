// SPDX-License-Identifier: Apache-2.0
// Where the rays of a pixel are within a mesh: what the fragments of its boundary say.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "render/passes/surface_raster.h"

namespace ovoid {

// Counts, at each place of a pixel, how many times a ray has come into the mesh more often than out
// of it. Counted from the eye and, where a ray's crossings do not cancel, from the far end, too:
// where a boundary is not closed, or the eye is within the mesh, either count tells that a ray is
// inside. Cells that overlap count twice.
class MeshCount {
 public:
  explicit MeshCount(std::span<const SurfaceFragment> fragments) {
    for (const SurfaceFragment& fragment : fragments) add(fragment, least_);
    for (int& least : least_) least = std::min(least, 0);
  }

  void pass(const SurfaceFragment& fragment) { add(fragment, count_); }
  bool is_inside(int place) const {
    const auto p = static_cast<std::size_t>(place);
    return count_[p] > least_[p];
  }

 private:
  using Counts = std::array<int, SurfaceRaster::kPlaces>;
  static void add(const SurfaceFragment& fragment, Counts& counts) {
    for (std::size_t p = 0; p < counts.size(); ++p) {
      if ((fragment.covered >> p & 1U) != 0) counts[p] += fragment.enters;
    }
  }

  Counts count_{};
  Counts least_{};  // of all, or 0: the count from the far end is count - all
};

// Whether two depths, the second behind, are so near each other that cells touch between them.
bool is_one_place(float depth, float behind);

// A pixel's fragments without boundaries at which the mesh goes on: where cells of different sizes
// meet, none of their faces is the other's, and rays leave and enter the mesh at once.
void drop_inner_boundaries(std::span<const SurfaceFragment> fragments,
                           std::vector<SurfaceFragment>& kept);

}  // namespace ovoid
