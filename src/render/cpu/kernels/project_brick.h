// SPDX-License-Identifier: Apache-2.0
// Stage "project" for a brick of kernels.
#pragma once

#include <cstdint>

#include "render/cpu/kernels/splat.h"

namespace ovoid::cpu {

// Writes the splats of brick `index` of the field's source to `out`, in the kernels' order, and
// returns how many there are: at most as many as kernels. Balls whose sigma is below what a splat
// has at least all become splats of that one size; those whose places differ by less than
// kMergedEdge of it are replaced by one, which has their mass, mean place and variance. Throws what
// the source throws.
std::int64_t project_brick(const KernelField& field, const view::KernelPlan& plan,
                           std::int64_t index, Merging merging, Splat* out);

}  // namespace ovoid::cpu
