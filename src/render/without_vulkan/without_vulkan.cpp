// SPDX-License-Identifier: Apache-2.0
// Stands in for the vulkan back end where the program is built without it.
#include "ovoid/devices.h"
#include "ovoid/error.h"
#include "render/back_end.h"

namespace ovoid {

std::unique_ptr<BackEnd> make_vulkan_back_end(const RendererSetup&) {
  throw Error(ErrorCode::kUnsupported,
              "backend vulkan: this program was built without it; backend cpu is there");
}

bool has_device_for_auto(const RendererSetup&) { return false; }

DeviceList list_devices(const VulkanSetup&) {
  return {{}, "this program was built without Vulkan"};
}

}  // namespace ovoid
