// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/kernel_block.h"

namespace ovoid::cpu {

// Draws the tile of kBlockEdge^2 pixels into work.tiles with the best SIMD target (or the one that
// OVOID_TARGET names, as simd_target_in_use() has found).
void render_kernel_tile(const KernelFrame& frame, KernelWorkspace& work, const TileRect& rect);

}  // namespace ovoid::cpu
