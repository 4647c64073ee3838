// SPDX-License-Identifier: Apache-2.0
// Memory that shaders read and write.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "render/vulkan/device.h"

namespace ovoid::vulkan {

enum class BufferUse {
  kDevice,    // the device's own memory; mapped, too, where host and device share theirs
  kUpload,    // written by the host, read by the device's copies
  kReadBack,  // the other way round
};

// Owns its memory. Not for several threads at once.
class Buffer {
 public:
  Buffer() = default;
  // Throws Error(kOutOfMemory); `bytes` 0 is made one.
  Buffer(std::shared_ptr<Device> device, std::uint64_t bytes, BufferUse use);
  ~Buffer();
  Buffer(Buffer&& other) noexcept;
  Buffer& operator=(Buffer&& other) noexcept;

  VkBuffer handle() const noexcept { return buffer_; }
  std::uint64_t bytes() const noexcept { return bytes_; }
  std::byte* mapped() const noexcept { return mapped_; }  // null: cannot be reached
  bool is_empty() const noexcept { return buffer_ == VK_NULL_HANDLE; }

 private:
  void release() noexcept;

  std::shared_ptr<Device> device_;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  std::uint64_t bytes_ = 0;
  std::byte* mapped_ = nullptr;
};

// A buffer that is at least so large; what it held is lost if it grows.
void reserve(Buffer& buffer, const std::shared_ptr<Device>& device, std::uint64_t bytes,
             BufferUse use);

}  // namespace ovoid::vulkan
