// SPDX-License-Identifier: Apache-2.0
// What is decided of a frame, as bits and numbers of the shaders' specialisation constants.
#pragma once

#include "ovoid/renderer.h"
#include "render/shared/kernel_values.h"
#include "render/shared/lattice_values.h"
#include "render/shared/view_values.h"

namespace ovoid::vulkan {

std::uint32_t frame_flags(const FrameTraits& traits, const RenderOptions& options);
std::uint32_t lattice_flags(const LatticeTraits& traits, bool is_double, bool may_miss);
std::uint32_t set_flags(const KernelTraits& traits, const KernelField& field, bool is_parallel);
std::uint32_t type_number(ScalarType type);

// Shaders know enumerators by their numbers, which layout_checks.cpp compares.
template <class Enumeration>
constexpr std::uint32_t number_of(Enumeration value) {
  return static_cast<std::uint32_t>(value);
}

}  // namespace ovoid::vulkan
