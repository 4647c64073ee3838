// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/result.h"

#include <fmt/format.h>

#include "ovoid/error.h"

namespace ovoid::vulkan {

void check(VkResult result, const char* doing) {
  if (result >= 0) return;
  switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY:
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
    case VK_ERROR_OUT_OF_POOL_MEMORY:
    case VK_ERROR_TOO_MANY_OBJECTS:
      throw Error(
          ErrorCode::kOutOfMemory,
          fmt::format("backend vulkan: the device's memory does not suffice for {}: expected "
                      "a smaller picture or device memory limit, or backend cpu",
                      doing));
    case VK_ERROR_DEVICE_LOST:
      throw Error(ErrorCode::kDeviceLost,
                  fmt::format("backend vulkan: the device was lost while {}: the next picture "
                              "starts it anew, backend cpu needs none",
                              doing));
    default:
      throw Error(ErrorCode::kUnsupported,
                  fmt::format("backend vulkan: the driver refused {} (VkResult {})", doing,
                              static_cast<int>(result)));
  }
}

}  // namespace ovoid::vulkan
