// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "render/back_end.h"

namespace ovoid::vulkan {

// The vulkan back end. Keeps fields on the device between frames, as long as they are drawn. One
// frame at a time.
class VulkanRenderer final : public BackEnd {
 public:
  // `device`: index, or -1 for the first hardware device, else the first; `most_bytes`: of its
  // memory for fields, 0 for most of it. Throws Error(kUnsupported) if there is none,
  // Error(kInvalidArgument).
  VulkanRenderer(int device, std::uint64_t most_bytes);
  ~VulkanRenderer() override;
  VulkanRenderer(const VulkanRenderer&) = delete;
  VulkanRenderer& operator=(const VulkanRenderer&) = delete;

  Frame draw(const FrameJob& job) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// True if there is a hardware device that could be used; with OVOID_AUTO_DEVICE=any in the
// environment, any device.
bool has_device_for_auto();

}  // namespace ovoid::vulkan
