// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/vulkan/api.h"

namespace ovoid::vulkan {

// Throws Error unless a call succeeded: kOutOfMemory, kDeviceLost, else kUnsupported. `doing` says
// what was tried ("making a buffer of 3 MiB").
void check(VkResult result, const char* doing);

}  // namespace ovoid::vulkan
