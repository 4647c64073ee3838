// SPDX-License-Identifier: Apache-2.0
// What surfaces beside a field absorb of the light: docs/numerics.md, "Surfaces in the light".
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <stop_token>

#include "ovoid/scene.h"
#include "render/light/extinction_lattice.h"

namespace ovoid {

// A lattice grows around its cells to hold surfaces: along each axis by at most half of its own
// longest side before and behind, and to as many cells in all, or twice its own.
inline constexpr std::int64_t kMostCellsWithSurfaces = std::int64_t{1} << 22;

// Which sides of a lattice surfaces reach beyond, and how many cells it has grown there.
struct GrownSides {
  Index3 before{}, behind{};
  std::array<bool, 3> is_cut_before{}, is_cut_behind{};
};

// Adds surfaces, which are valid, to a lattice without any. A place that has no value, or is not
// finite, absorbs nothing. The result does not depend on `threads`. Cost: three times through the
// triangles, and 16 rays through each column of cells that they cover; some 30 bytes for each cell
// for a while, and 36 for each that surfaces pass through. Throws Error(kCancelled).
GrownSides add_surfaces(std::span<const Geometry> geometry, int threads,
                        const std::stop_token& stop, ExtinctionLattice& lattice);

}  // namespace ovoid
