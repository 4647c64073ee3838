// SPDX-License-Identifier: Apache-2.0
#include "ovoid/devices.h"

#ifdef OVOID_VULKAN
#include "ovoid/error.h"
#include "render/vulkan/instance.h"
#endif

namespace ovoid {

const char* name_of(DeviceKind kind) noexcept {
  switch (kind) {
    case DeviceKind::kDiscrete:
      return "discrete";
    case DeviceKind::kIntegrated:
      return "integrated";
    case DeviceKind::kVirtual:
      return "virtual";
    case DeviceKind::kSoftware:
      return "software";
    case DeviceKind::kOther:
      break;
  }
  return "other";
}

#ifdef OVOID_VULKAN
DeviceList list_devices(const VulkanSetup& setup) {
  DeviceList list;
  try {
    const std::shared_ptr<vulkan::Instance> instance = vulkan::Instance::get(setup);
    for (int i = 0; i < static_cast<int>(instance->physical_devices().size()); ++i)
      list.devices.push_back(instance->info_of(i));
    if (list.devices.empty()) list.problem = "no Vulkan driver on this machine has a device";
  } catch (const Error& error) {
    list.problem = error.what();
  }
  return list;
}
#else
DeviceList list_devices(const VulkanSetup& /*setup*/) {
  return {{}, "this program was built without Vulkan"};
}
#endif

}  // namespace ovoid
