// SPDX-License-Identifier: Apache-2.0
// The loader, the instance, and the devices that there are.
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "ovoid/devices.h"
#include "render/vulkan/api.h"

namespace ovoid::vulkan {

// The process has one at a time, made by the first who needs it. The validation layer checks
// synchronisation, too.
class Instance {
 public:
  // Throws Error(kUnsupported): no loader, too old a one, the validation layer wanted and absent.
  static std::shared_ptr<Instance> get(const VulkanSetup& setup);
  ~Instance();
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  const std::vector<VkPhysicalDevice>& physical_devices() const noexcept { return devices_; }
  DeviceInfo info_of(int index) const;

  // What the validation layer had to say since the last call; empty without it.
  std::vector<std::string> take_messages();

 private:
  explicit Instance(const VulkanSetup& setup);
  void create();
  void listen();
  static VkBool32 VKAPI_PTR hear(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                 VkDebugUtilsMessageTypeFlagsEXT types,
                                 const VkDebugUtilsMessengerCallbackDataEXT* data, void* instance);

  void* library_ = nullptr;
  VkInstance instance_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  const bool validates_;
  std::vector<VkPhysicalDevice> devices_;
  std::mutex mutex_;
  std::vector<std::string> messages_;
};

// Of a physical device's queue families the first that computes; -1: none does.
int compute_family(VkPhysicalDevice device);

}  // namespace ovoid::vulkan
