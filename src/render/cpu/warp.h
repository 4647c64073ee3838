// SPDX-License-Identifier: Apache-2.0
// Stage "warp": from the base plane's picture to the one that is seen (docs/numerics.md, "Lattice
// sheets").
#pragma once

#include <vector>

#include "render/cpu/block.h"
#include "view/base_plane.h"

namespace ovoid::cpu {

// True if some pixel of the picture takes samples of the tile.
bool is_seen(const view::BasePlane& base, const TileRect& tile);

// Rows of the picture that are warped as one task.
std::vector<TileRect> strips_of(const RenderOptions& options);

// Sets the pixels of `strip` from the samples of the base plane. `is_bounded`: they are colours and
// opacities in [0, 1].
void warp(const view::BasePlane& base, const Image& samples, bool is_bounded, const TileRect& strip,
          Image& picture);

}  // namespace ovoid::cpu
