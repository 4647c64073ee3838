// SPDX-License-Identifier: Apache-2.0
// Which blocks of a summed field can show, from the splats that reach them. A brick of kernels says
// nothing about a sum; its splats do: no sample has more than the heights of those that reach it.
#pragma once

#include <cstdint>
#include <vector>

#include "render/cpu/kernels/splat.h"
#include "render/cpu/runner.h"

namespace ovoid::cpu {

// For each block, 1 if it is relevant in the plan and may show. Cost: a few cells of 8 x 8 pixels
// for each splat of a block.
std::vector<std::uint8_t> visible_sums(const view::KernelPlan& plan, const BinnedSplats& binned,
                                       Runner& runner);

}  // namespace ovoid::cpu
