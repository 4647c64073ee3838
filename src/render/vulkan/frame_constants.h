// SPDX-License-Identifier: Apache-2.0
// A frame's plan, look and field in the form that shaders read.
#pragma once

#include <vector>

#include "ovoid/renderer.h"
#include "render/shared/device_layout.h"
#include "view/frame_plan.h"

namespace ovoid::vulkan {

// All tables of a frame, one behind the other, in vectors of four numbers.
using Tables = std::vector<device::vec4>;

device::ViewConstants view_constants(const view::FramePlan& plan, const RenderOptions& options);

// Appends the look's tables to `tables`.
device::LookConstants look_constants(const view::FramePlan& plan, const Look& look,
                                     const ValueRange& range, Tables& tables);

device::LatticeConstants lattice_constants(const LatticeField& field, const view::LatticePlan& plan,
                                           const RenderOptions& options);

// Bits of the specialisation constants of a frame, and of a lattice in it.
std::uint32_t frame_flags(const view::FramePlan& plan, const Look& look,
                          const RenderOptions& options);
std::uint32_t lattice_flags(const LatticeField& field, const RenderOptions& options, bool may_miss);
std::uint32_t mode_number(Mode mode);
std::uint32_t type_number(ScalarType type);

}  // namespace ovoid::vulkan
