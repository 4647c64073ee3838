// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "ovoid/renderer.h"
#include "view/behind.h"

namespace ovoid::vulkan {

// The vulkan back end. Keeps fields on the device between frames, as long as they are drawn. One
// frame at a time.
class VulkanRenderer {
 public:
  // Throws Error(kUnsupported) if there is no such device, Error(kInvalidArgument).
  explicit VulkanRenderer(const RendererSetup& setup);
  ~VulkanRenderer();
  VulkanRenderer(const VulkanRenderer&) = delete;
  VulkanRenderer& operator=(const VulkanRenderer&) = delete;

  // Arguments have been validated. Throws Error, also kDeviceLost and kOutOfMemory.
  Frame render(const LatticeField& field, const Camera& camera, const Look& look,
               const RenderOptions& options, const RenderHooks& hooks,
               const view::Behind* behind = nullptr);
  Frame render(const KernelField& field, const Camera& camera, const Look& look,
               const RenderOptions& options, const RenderHooks& hooks);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// True if there is a device that could be used and that kAuto takes.
bool has_device_for_auto(const RendererSetup& setup);

}  // namespace ovoid::vulkan
