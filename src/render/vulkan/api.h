// SPDX-License-Identifier: Apache-2.0
// Vulkan's functions, found at run time: nothing of this program needs the loader to be there.
#pragma once

#define VK_NO_PROTOTYPES
#include <volk.h>

namespace ovoid::vulkan {

// One of Vulkan's structures, empty but for its type.
template <class T>
T structure(VkStructureType type) {
  T made{};
  made.sType = type;
  return made;
}

}  // namespace ovoid::vulkan
