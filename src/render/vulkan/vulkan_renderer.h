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
  // Throws Error(kUnsupported) if there is no such device, Error(kInvalidArgument).
  explicit VulkanRenderer(const RendererSetup& setup);
  ~VulkanRenderer() override;
  VulkanRenderer(const VulkanRenderer&) = delete;
  VulkanRenderer& operator=(const VulkanRenderer&) = delete;

  Backend kind() const noexcept override { return Backend::kVulkan; }
  Frame draw(const FrameJob& job) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// True if there is a device that could be used and that kAuto takes.
bool has_device_for_auto(const RendererSetup& setup);

}  // namespace ovoid::vulkan
