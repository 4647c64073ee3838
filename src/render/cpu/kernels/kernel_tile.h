// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/kernels/kernel_block.h"
#include "simd/simd_target.h"

namespace ovoid::cpu {

// Draws the tile of kBlockEdge^2 pixels into work.subtiles.
void render_kernel_tile(const simd::SimdTarget& target, const KernelFrame& frame,
                        KernelTileWorkspace& work, const TileRect& rect);

}  // namespace ovoid::cpu
