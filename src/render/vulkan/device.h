// SPDX-License-Identifier: Apache-2.0
// One device: its queue, its limits, and the pipelines that were made on it.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "render/vulkan/instance.h"
#include "render/vulkan/stages.h"

namespace ovoid::vulkan {

struct Pipeline {
  VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkPipeline pipeline = VK_NULL_HANDLE;
  std::uint32_t num_bindings = 0;
  bool has_frame = false;  // Shader::has_frame
};

// Values of the specialisation constants 0, 1, ...
using Constants = std::vector<std::uint32_t>;

// Memory that the host sees, with what the device writes, without further ado.
inline constexpr VkMemoryPropertyFlags kMapped =
    VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;

// Shared by all renderers of the process that use it; its members may be called from any thread.
class Device {
 public:
  // `index` of the loader's list; -1: the first hardware device, else the first. Throws
  // Error(kUnsupported) if there is none or it lacks something, Error(kInvalidArgument) for an
  // index out of range.
  static std::shared_ptr<Device> get(int index, const VulkanSetup& setup);
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  const VolkDeviceTable& vk() const noexcept { return vk_; }
  VkDevice handle() const noexcept { return device_; }
  VkQueue queue() const noexcept { return queue_; }
  std::mutex& queue_mutex() noexcept { return queue_mutex_; }
  std::uint32_t family() const noexcept { return family_; }
  const VkPhysicalDeviceLimits& limits() const noexcept { return limits_; }
  const DeviceInfo& info() const noexcept { return info_; }
  // Host and device work on the same memory: nothing need be copied.
  bool shares_memory() const noexcept {
    return info_.kind == DeviceKind::kIntegrated || info_.kind == DeviceKind::kSoftware;
  }
  bool has_timestamps() const noexcept {
    return limits_.timestampPeriod > 0 && timestamp_bits_ > 0;
  }

  // The type of memory that a buffer goes to: of those allowed the first that has all `needed` and
  // `wanted` flags, else all needed. -1: none.
  int memory_type(std::uint32_t allowed, VkMemoryPropertyFlags needed,
                  VkMemoryPropertyFlags wanted) const noexcept;
  bool is_host_visible(int type) const noexcept;

  // The pipeline of a shader, which must outlive the device, with these constants; made when it is
  // first asked for.
  const Pipeline& pipeline(const Shader& shader, const Constants& constants);

  // Lost: another get() makes a new one.
  void mark_lost() noexcept { is_lost_ = true; }
  bool is_lost() const noexcept { return is_lost_; }

  // Throws Error(kUnsupported) with what the validation layer has said, if it has.
  void check_messages();

 private:
  Device(std::shared_ptr<Instance> instance, int index);
  Pipeline make_pipeline(const Shader& shader, const Constants& constants) const;

  std::shared_ptr<Instance> instance_;
  DeviceInfo info_;
  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  VkPhysicalDeviceLimits limits_{};
  VkPhysicalDeviceMemoryProperties memory_{};
  std::uint32_t family_ = 0;
  std::uint32_t timestamp_bits_ = 0;
  VkDevice device_ = VK_NULL_HANDLE;
  VkQueue queue_ = VK_NULL_HANDLE;
  VolkDeviceTable vk_{};
  std::mutex queue_mutex_;
  std::mutex mutex_;
  std::map<std::pair<const Shader*, Constants>, Pipeline> pipelines_;
  bool is_lost_ = false;
};

}  // namespace ovoid::vulkan
