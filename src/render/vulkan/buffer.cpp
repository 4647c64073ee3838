// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/buffer.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "render/vulkan/result.h"

namespace ovoid::vulkan {
namespace {

VkBufferUsageFlags usage_of(BufferUse use) {
  switch (use) {
    case BufferUse::kUpload:
      return VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
    case BufferUse::kReadBack:
      return VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    case BufferUse::kDevice:
      break;
  }
  return VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT |
         VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
}

}  // namespace

Buffer::Buffer(std::shared_ptr<Device> device, std::uint64_t bytes, BufferUse use)
    : device_(std::move(device)), bytes_(std::max<std::uint64_t>((bytes + 3) / 4 * 4, 4)) {
  const VolkDeviceTable& vk = device_->vk();
  const std::string doing = fmt::format("a buffer of {} MiB", (bytes_ + (1U << 20U) - 1) >> 20U);
  auto info = structure<VkBufferCreateInfo>(VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO);
  info.size = bytes_;
  info.usage = usage_of(use);
  info.sharingMode = VK_SHARING_MODE_EXCLUSIVE;
  check(vk.vkCreateBuffer(device_->handle(), &info, nullptr, &buffer_), doing.c_str());
  VkMemoryRequirements needs;
  vk.vkGetBufferMemoryRequirements(device_->handle(), buffer_, &needs);
  const VkMemoryPropertyFlags needed = use == BufferUse::kDevice ? 0 : kMapped;
  // What is read back is read by the processor word by word: better from its cache.
  const VkMemoryPropertyFlags wanted =
      use == BufferUse::kReadBack ? VK_MEMORY_PROPERTY_HOST_CACHED_BIT
      : use == BufferUse::kDevice ? VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT
                                  : 0;
  const int type = device_->memory_type(needs.memoryTypeBits, needed, wanted);
  auto allocation = structure<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
  allocation.allocationSize = needs.size;
  allocation.memoryTypeIndex = static_cast<std::uint32_t>(std::max(type, 0));
  try {
    check(type < 0 ? VK_ERROR_OUT_OF_DEVICE_MEMORY
                   : vk.vkAllocateMemory(device_->handle(), &allocation, nullptr, &memory_),
          doing.c_str());
    check(vk.vkBindBufferMemory(device_->handle(), buffer_, memory_, 0), doing.c_str());
    const bool is_mapped = use != BufferUse::kDevice || device_->shares_memory();
    if (is_mapped && device_->is_host_visible(type)) {
      void* at = nullptr;
      check(vk.vkMapMemory(device_->handle(), memory_, 0, VK_WHOLE_SIZE, 0, &at), doing.c_str());
      mapped_ = static_cast<std::byte*>(at);
    }
  } catch (...) {
    release();
    throw;
  }
}

Buffer::~Buffer() { release(); }

void Buffer::release() noexcept {
  if (buffer_ == VK_NULL_HANDLE) return;
  device_->vk().vkDestroyBuffer(device_->handle(), buffer_, nullptr);
  device_->vk().vkFreeMemory(device_->handle(), memory_, nullptr);
  buffer_ = VK_NULL_HANDLE;
}

Buffer::Buffer(Buffer&& other) noexcept { *this = std::move(other); }

Buffer& Buffer::operator=(Buffer&& other) noexcept {
  if (this == &other) return *this;
  release();
  device_ = std::move(other.device_);
  buffer_ = std::exchange(other.buffer_, VK_NULL_HANDLE);
  memory_ = std::exchange(other.memory_, VK_NULL_HANDLE);
  bytes_ = std::exchange(other.bytes_, 0);
  mapped_ = std::exchange(other.mapped_, nullptr);
  return *this;
}

void reserve(Buffer& buffer, const std::shared_ptr<Device>& device, std::uint64_t bytes,
             BufferUse use) {
  if (!buffer.is_empty() && buffer.bytes() >= bytes) return;
  buffer = Buffer();  // the old one's memory first
  buffer = Buffer(device, bytes, use);
}

}  // namespace ovoid::vulkan
