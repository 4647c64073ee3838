// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>

#include "data/kernels/kernel_bricks.h"
#include "ovoid/kernel_field.h"

namespace ovoid::data {

// make_kernel_source() of kernels that are some of all, and lie in the columns group by group.
// Without groups they are all.
std::shared_ptr<const KernelSource> resident_kernels(const KernelColumns& columns,
                                                     std::span<const KernelGroup> groups,
                                                     int threads);

}  // namespace ovoid::data
