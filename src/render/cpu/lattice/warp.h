// SPDX-License-Identifier: Apache-2.0
// Stage "warp": from the base plane's picture to the one that is seen (docs/numerics.md, "Lattice
// sheets").
#pragma once

#include <cstdint>
#include <vector>

#include "render/cpu/lattice/block.h"
#include "render/cpu/runner.h"
#include "simd/simd_target.h"
#include "view/plan/base_plane.h"

namespace ovoid::cpu {

// Samples along a side of what the warp skips where the base plane is empty.
inline constexpr int kSpotSize = 16;

// The base plane's picture, and which of its squares of kSpotSize samples hold anything.
struct BasePicture {
  BasePicture(Image picture, Runner& runner);

  bool holds_something(int x, int y) const noexcept {
    return tiles[static_cast<std::size_t>(y / kSpotSize) * tiles_across +
                 static_cast<std::size_t>(x / kSpotSize)] != 0;
  }

  Image image;
  std::size_t tiles_across;
  std::vector<std::uint8_t> tiles;
};

// True if some pixel of the picture takes samples of the tile.
bool is_seen(const view::BasePlane& base, const TileRect& tile);

// Rows of the picture that are warped as one task.
std::vector<TileRect> strips_of(const RenderOptions& options);

struct WarpJob {
  const view::BasePlane& base;
  const BasePicture& samples;
};

// Sets the pixels of `strip`.
void warp(const simd::SimdTarget& target, const WarpJob& job, const TileRect& strip,
          Image& picture);

}  // namespace ovoid::cpu
