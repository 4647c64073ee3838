// SPDX-License-Identifier: Apache-2.0
// What of a kernel set's frame shaders read, beside what every frame has (frame_constants.h).
#pragma once

#include "ovoid/field.h"
#include "render/shared/device_layout.h"
#include "view/kernel_plan.h"

namespace ovoid::vulkan {

// Bits of the specialisation constants, and numbers, that tell of a set.
std::uint32_t set_flags(const KernelField& field, const view::KernelPlan& plan,
                        const RenderOptions& options, bool has_levels);
std::uint32_t profile_number(KernelProfile profile);

// What is summed over splats: docs/numerics.md, "Kernel sets".
std::uint32_t num_channels(const KernelField& field);

// Splat space.
void set_space(device::KernelFrame& frame, const view::KernelPlan& plan);

// The filter from a level to the finer one.
void set_taps(device::KernelFrame& frame, PostConvolution how);

}  // namespace ovoid::vulkan
