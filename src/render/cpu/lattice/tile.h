// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/lattice/nodes.h"
#include "simd/simd_target.h"

namespace ovoid::cpu {

// Draws a patch, or one tile if the frame has no nodes, into work.tiles. `wanted`: the samples of
// the one tile that are to be drawn, row after row; null: all. Brick sources may throw.
void render_patch(const simd::SimdTarget& target, const LatticeFrame& frame, LatticeWorkspace& work,
                  const TileRect& rect, const RowWord* wanted);

}  // namespace ovoid::cpu
