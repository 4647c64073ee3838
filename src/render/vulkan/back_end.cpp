// SPDX-License-Identifier: Apache-2.0
// The vulkan back end and its devices, as the library asks for them.
#include "render/back_end.h"

#include "ovoid/devices.h"
#include "ovoid/error.h"
#include "render/vulkan/instance.h"
#include "render/vulkan/vulkan_renderer.h"

namespace ovoid {

std::unique_ptr<BackEnd> make_vulkan_back_end(const RendererSetup& setup) {
  return std::make_unique<vulkan::VulkanRenderer>(setup);
}

bool has_device_for_auto(const RendererSetup& setup) { return vulkan::has_device_for_auto(setup); }

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

}  // namespace ovoid
