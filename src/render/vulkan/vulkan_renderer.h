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
  // `device`: index, or -1 for the first hardware device, else the first; `most_bytes`: of its
  // memory for fields, 0 for most of it. Throws Error(kUnsupported) if there is none,
  // Error(kInvalidArgument).
  VulkanRenderer(int device, std::uint64_t most_bytes);
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

// True if there is a hardware device that could be used; with OVOID_AUTO_DEVICE=any in the
// environment, any device.
bool has_device_for_auto();

}  // namespace ovoid::vulkan
