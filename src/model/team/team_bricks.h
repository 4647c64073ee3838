// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "model/particles/kernel_parts.h"
#include "ovoid/kernel_field.h"

namespace ovoid::model {

// The kernels of all processes in the bricks that one process would make of them, each of which is
// kept by one. All call it. `kept_bytes`: as TeamFieldOptions has it. Throws what
// make_kernel_source() and the team throw.
std::shared_ptr<const KernelSource> share_in_bricks(const ModelRun& run, KernelParts parts,
                                                    std::int64_t kept_bytes);

}  // namespace ovoid::model
