// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "render/cpu/nodes.h"

namespace ovoid::cpu {

// Draws a patch, or one tile if the frame has no nodes, into work.tiles with the best SIMD target
// (or the one that OVOID_TARGET names). Brick sources may throw.
void render_patch(const CpuFrame& frame, LatticeWorkspace& work, const TileRect& rect);

// The target that render_patch() uses, and all targets that it could use, best first. Throws
// Error(kInvalidArgument) if OVOID_TARGET names one that this build or machine does not have.
std::string simd_target_in_use();
std::vector<std::string> usable_simd_targets();

}  // namespace ovoid::cpu
