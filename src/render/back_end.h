// SPDX-License-Identifier: Apache-2.0
// What Renderer draws with. One of each kind, chosen once; renderer.cpp knows no more of them.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "ovoid/renderer.h"
#include "view/plan/base_plane.h"
#include "view/plan/further_volume.h"
#include "view/plan/light_volume.h"
#include "view/plan/trail_view.h"

namespace ovoid {

// A frame of fields, within the limits of its options; all of it has been validated.
struct FrameJob {
  const Field& field;
  const Camera& camera;
  const Look& look;
  const view::TrailView* trail;  // null: none
  const RenderOptions& options;
  const RenderHooks& hooks;
  const view::LightVolume* light = nullptr;  // how much of it arrives where; null: all
  const view::BasePlane* base = nullptr;     // of lattice sheets; null: image sheets
  std::span<const FurtherVolume> further{};  // mixed with the field; their looks are completed
  Mixing mixing = Mixing::kAveraged;         // of the field and these
};

class BackEnd {
 public:
  virtual ~BackEnd() = default;
  virtual Backend kind() const noexcept = 0;  // not kAuto
  // Throws Error, also kDeviceLost and kOutOfMemory, and what the hooks throw. One frame at a time.
  virtual Frame draw(const FrameJob& job) = 0;
};

// Draws on a device of the setup. Throws Error: kUnsupported where there is none, or where the
// program was built without Vulkan (without_vulkan/); kInvalidArgument.
std::unique_ptr<BackEnd> make_vulkan_back_end(const RendererSetup& setup);

// True if Backend::kAuto takes a device of this machine and setup.
bool has_device_for_auto(const RendererSetup& setup);

}  // namespace ovoid
