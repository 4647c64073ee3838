// SPDX-License-Identifier: Apache-2.0
// A frame of a kernel set: the plan on the host, then project, bin, reconstruct and shade on the
// device, front to back, as many layers of sheets at a time as there is room for.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "render/back_end.h"
#include "render/shared/device_layout.h"
#include "render/shared/kernel_values.h"
#include "render/vulkan/device_kernels.h"
#include "render/vulkan/workbench.h"
#include "view/plan/kernel_plan.h"

namespace ovoid::vulkan {

class KernelRenderer {
 public:
  explicit KernelRenderer(Workbench& bench) : bench_(bench) {}

  // Draws into `image`, which is empty, and counts in `profile`.
  void render(const FrameJob& job, Image& image, FrameProfile& profile);

 private:
  struct Set;  // a frame's field, plan and constants

  // Layers [first, end), whose splats and lists the device has.
  struct Layers {
    int first = 0, end = 0;
    std::uint32_t num_splats = 0;
    std::uint32_t num_pairs = 0;
    int coarsest = 0;
  };

  void set_constants(Set& set);
  void set_needs(Set& set);
  void prepare_strip(Set& set, const Strip& strip);
  // False if what reaches its rows does not fit, even layer by layer.
  bool draw_strip(Set& set, const Strip& strip, const RenderHooks& hooks, FrameProfile& profile);
  // From `first` on as many as there is room for; none: not even one.
  std::optional<Layers> bin_layers(Set& set, int first);
  Layers project_layers(Set& set, int first, int end);
  void list_and_sort(Set& set, const Layers& layers);
  void require_short_loops(const Set& set, const Layers& layers, std::uint32_t num_lists);
  void scan(const Buffer& numbers, std::uint32_t count);
  void reconstruct(Set& set, const Layers& layers, int first, int end);
  void shade(Set& set, const Strip& strip, int first_sheet, int end_sheet);
  device::KernelPush push_of(const Layers& layers) const;

  Workbench& bench_;
  std::unique_ptr<DeviceKernels> kernels_;
  Buffer frame_, tables_, bricks_, needed_layers_, needed_blocks_, splats_, offsets_, coarsest_;
  std::array<Buffer, 3> sums_;
  Buffer pairs_, other_pairs_, digits_, ends_, open_, planes_, sheets_, color_sheets_, counts_;
};

}  // namespace ovoid::vulkan
