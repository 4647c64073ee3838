// SPDX-License-Identifier: Apache-2.0
// The layouts that host and shaders share, read out of the compiled shaders.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstring>
#include <map>
#include <set>
#include <string>

#include "render/shared/device_layout.h"
#include "render/vulkan/stages.h"

namespace ovoid::vulkan {
namespace layout_test {

using Offsets = std::map<std::string, std::uint32_t>;  // by "Structure.member"

// What a shader says of itself: offsets of its structures' members, its bindings, the size of its
// work group. Of SPIR-V's instructions those that name and decorate.
struct Reflection {
  Offsets offsets;
  std::set<std::uint32_t> bindings;
  std::uint32_t group_size = 0;
};

std::string text_at(const std::uint32_t* words) { return reinterpret_cast<const char*>(words); }

Reflection reflect(std::span<const std::uint32_t> code) {
  constexpr std::uint32_t kOpName = 5, kOpMemberName = 6, kOpExecutionMode = 16, kOpDecorate = 71,
                          kOpMemberDecorate = 72;
  constexpr std::uint32_t kBinding = 33, kOffset = 35, kLocalSize = 17;
  Reflection found;
  std::map<std::uint32_t, std::string> names;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::string> members;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> offsets;
  for (std::size_t at = 5; at < code.size(); at += code[at] >> 16U) {
    const std::uint32_t* const words = code.data() + at;
    const std::uint32_t operation = words[0] & 0xFFFFU;
    if (operation == kOpName) names[words[1]] = text_at(words + 2);
    if (operation == kOpMemberName) members[{words[1], words[2]}] = text_at(words + 3);
    if (operation == kOpMemberDecorate && words[3] == kOffset)
      offsets[{words[1], words[2]}] = words[4];
    if (operation == kOpDecorate && words[2] == kBinding) found.bindings.insert(words[3]);
    if (operation == kOpExecutionMode && words[2] == kLocalSize)
      found.group_size = words[3] * words[4] * words[5];
  }
  // A structure that no buffer holds has no offsets.
  for (const auto& [member, offset] : offsets)
    found.offsets[names[member.first] + "." + members[member]] = offset;
  return found;
}

struct Member {
  const char* name;
  std::size_t offset;
};

#define OVOID_MEMBER(structure, member) \
  { #structure "." #member, offsetof(device::structure, member) }

constexpr Member kMembers[] = {
    OVOID_MEMBER(TableConstants, scale),
    OVOID_MEMBER(TableConstants, origin),
    OVOID_MEMBER(TableConstants, origin_bits),
    OVOID_MEMBER(TableConstants, cells_per_step),
    OVOID_MEMBER(TableConstants, inverse_width),
    OVOID_MEMBER(TableConstants, visible_lo),
    OVOID_MEMBER(TableConstants, visible_hi),
    OVOID_MEMBER(TableConstants, entries_at),
    OVOID_MEMBER(TableConstants, steps_at),
    OVOID_MEMBER(TableConstants, padding0),
    OVOID_MEMBER(TableConstants, padding1),
    OVOID_MEMBER(TableConstants, padding2),
    OVOID_MEMBER(LookConstants, look),
    OVOID_MEMBER(LookConstants, color),
    OVOID_MEMBER(LookConstants, fading),
    OVOID_MEMBER(LookConstants, integrals_before),
    OVOID_MEMBER(LookConstants, integrals_behind),
    OVOID_MEMBER(LookConstants, isosurface_color),
    OVOID_MEMBER(LookConstants, light),
    OVOID_MEMBER(LookConstants, volume),
    OVOID_MEMBER(LightConstants, start),
    OVOID_MEMBER(LightConstants, step),
    OVOID_MEMBER(LightConstants, shift),
    OVOID_MEMBER(LightConstants, dims),
    OVOID_MEMBER(LookConstants, integral_per_value),
    OVOID_MEMBER(LookConstants, integral_lo),
    OVOID_MEMBER(LookConstants, integral_hi),
    OVOID_MEMBER(LookConstants, integrals_at),
    OVOID_MEMBER(LookConstants, ambient),
    OVOID_MEMBER(LookConstants, diffuse),
    OVOID_MEMBER(LookConstants, specular),
    OVOID_MEMBER(LookConstants, specular_power),
    OVOID_MEMBER(LookConstants, flat_gradient_inverse),
    OVOID_MEMBER(LookConstants, path_in_units),
    OVOID_MEMBER(LookConstants, isovalue),
    OVOID_MEMBER(LookConstants, light_kind),
    OVOID_MEMBER(LookConstants, variation_at),
    OVOID_MEMBER(LookConstants, num_further_lights),
    OVOID_MEMBER(LookConstants, padding0),
    OVOID_MEMBER(LookConstants, padding1),
    OVOID_MEMBER(LookConstants, further_lights),
    OVOID_MEMBER(Sublattice, dims),
    OVOID_MEMBER(Sublattice, offset),
    OVOID_MEMBER(SlabPoint, offset),
    OVOID_MEMBER(SlabPoint, weight),
    OVOID_MEMBER(LatticeConstants, place_hi),
    OVOID_MEMBER(LatticeConstants, place_lo),
    OVOID_MEMBER(LatticeConstants, step_hi),
    OVOID_MEMBER(LatticeConstants, step_lo),
    OVOID_MEMBER(LatticeConstants, gradient_rows),
    OVOID_MEMBER(LatticeConstants, camera_rows),
    OVOID_MEMBER(LatticeConstants, camera_columns),
    OVOID_MEMBER(LatticeConstants, inverse_spacing),
    OVOID_MEMBER(LatticeConstants, widening_limit),
    OVOID_MEMBER(LatticeConstants, support_lo),
    OVOID_MEMBER(LatticeConstants, support_hi),
    OVOID_MEMBER(LatticeConstants, inner_piece),
    OVOID_MEMBER(LatticeConstants, outer_piece),
    OVOID_MEMBER(LatticeConstants, faces_lo),
    OVOID_MEMBER(LatticeConstants, faces_hi),
    OVOID_MEMBER(LatticeConstants, slab),
    OVOID_MEMBER(LatticeConstants, num_bricks),
    OVOID_MEMBER(LatticeConstants, sublattices),
    OVOID_MEMBER(LatticeConstants, sigma),
    OVOID_MEMBER(LatticeConstants, support),
    OVOID_MEMBER(LatticeConstants, inverse_variance),
    OVOID_MEMBER(LatticeConstants, sum_weight),
    OVOID_MEMBER(LatticeConstants, near_weight),
    OVOID_MEMBER(LatticeConstants, far_weight),
    OVOID_MEMBER(LatticeConstants, value_scale),
    OVOID_MEMBER(LatticeConstants, value_offset),
    OVOID_MEMBER(LatticeConstants, num_slab_points),
    OVOID_MEMBER(LatticeConstants, num_sublattices),
    OVOID_MEMBER(LatticeConstants, inverse_unit),
    OVOID_MEMBER(LatticeConstants, is_piecewise),
    OVOID_MEMBER(ClipConstants, at_first),
    OVOID_MEMBER(ClipConstants, per_sheet),
    OVOID_MEMBER(ViewConstants, right),
    OVOID_MEMBER(ViewConstants, up),
    OVOID_MEMBER(ViewConstants, axis),
    OVOID_MEMBER(ViewConstants, ray),
    OVOID_MEMBER(ViewConstants, slope_right),
    OVOID_MEMBER(ViewConstants, slope_up),
    OVOID_MEMBER(ViewConstants, clips),
    OVOID_MEMBER(ViewConstants, width),
    OVOID_MEMBER(ViewConstants, height),
    OVOID_MEMBER(ViewConstants, num_sheets),
    OVOID_MEMBER(ViewConstants, num_clips),
    OVOID_MEMBER(ViewConstants, sampling_distance),
    OVOID_MEMBER(ViewConstants, first_depth),
    OVOID_MEMBER(ViewConstants, near_cut),
    OVOID_MEMBER(ViewConstants, pitch),
    OVOID_MEMBER(ViewConstants, pitch_per_sheet),
    OVOID_MEMBER(ViewConstants, opaque_at),
    OVOID_MEMBER(ViewConstants, gradient_pitch),
    OVOID_MEMBER(ViewConstants, gradient_pitch_per_sheet),
    OVOID_MEMBER(ViewConstants, gradient_step),
    OVOID_MEMBER(ViewConstants, num_cut_faces),
    OVOID_MEMBER(ViewConstants, clearance_per_length),
    OVOID_MEMBER(ViewConstants, padding0),
    OVOID_MEMBER(LatticeFrame, view),
    OVOID_MEMBER(LatticeFrame, looks),
    OVOID_MEMBER(LatticeFrame, fields),
    OVOID_MEMBER(BoxConstants, own_lo),
    OVOID_MEMBER(BoxConstants, own_hi),
    OVOID_MEMBER(BoxConstants, stored_lo),
    OVOID_MEMBER(BoxConstants, stored_bricks),
    OVOID_MEMBER(BoxConstants, tile_x),
    OVOID_MEMBER(BoxConstants, tile_y),
    OVOID_MEMBER(BoxConstants, first_row),
    OVOID_MEMBER(BoxConstants, end_row),
    OVOID_MEMBER(BoxConstants, first_sheet),
    OVOID_MEMBER(BoxConstants, end_sheet),
    OVOID_MEMBER(BoxConstants, node_step),
    OVOID_MEMBER(BoxConstants, padding),
    OVOID_MEMBER(DistanceConstants, num_bricks),
    OVOID_MEMBER(LevelConstants, tiles),
    OVOID_MEMBER(LevelConstants, first_list),
    OVOID_MEMBER(LevelConstants, plane_at),
    OVOID_MEMBER(LevelConstants, padding0),
    OVOID_MEMBER(LevelConstants, padding1),
    OVOID_MEMBER(KernelFrame, view),
    OVOID_MEMBER(KernelFrame, looks),
    OVOID_MEMBER(KernelFrame, rotation),
    OVOID_MEMBER(KernelFrame, levels),
    OVOID_MEMBER(KernelFrame, taps),
    OVOID_MEMBER(KernelFrame, num_blocks),
    OVOID_MEMBER(KernelFrame, pitch),
    OVOID_MEMBER(KernelFrame, sampling_distance),
    OVOID_MEMBER(KernelFrame, focal_depth),
    OVOID_MEMBER(KernelFrame, first_depth),
    OVOID_MEMBER(KernelFrame, center_x),
    OVOID_MEMBER(KernelFrame, center_y),
    OVOID_MEMBER(KernelFrame, near_depth),
    OVOID_MEMBER(KernelFrame, cutoff),
    OVOID_MEMBER(KernelFrame, least_pixels),
    OVOID_MEMBER(KernelFrame, least_level_sigma),
    OVOID_MEMBER(KernelFrame, sheet_scale),
    OVOID_MEMBER(KernelFrame, sheet_offset),
    OVOID_MEMBER(KernelFrame, num_sheets),
    OVOID_MEMBER(KernelFrame, max_level),
    OVOID_MEMBER(KernelFrame, ring_sheets),
    OVOID_MEMBER(KernelFrame, num_numbers),
    OVOID_MEMBER(BrickConstants, origin),
    OVOID_MEMBER(BrickConstants, first),
    OVOID_MEMBER(BrickConstants, count),
    OVOID_MEMBER(BrickConstants, first_splat),
    OVOID_MEMBER(BrickConstants, padding),
    OVOID_MEMBER(DeviceSplat, center),
    OVOID_MEMBER(DeviceSplat, shape),
    OVOID_MEMBER(DeviceSplat, slide),
    OVOID_MEMBER(DeviceSplat, values),
    OVOID_MEMBER(KernelPush, first_layer),
    OVOID_MEMBER(KernelPush, end_layer),
    OVOID_MEMBER(KernelPush, layer),
    OVOID_MEMBER(KernelPush, coarsest),
    OVOID_MEMBER(KernelPush, level),
    OVOID_MEMBER(KernelPush, first_sheet),
    OVOID_MEMBER(KernelPush, end_sheet),
    OVOID_MEMBER(KernelPush, num_items),
    OVOID_MEMBER(KernelPush, shift),
    OVOID_MEMBER(KernelPush, first_row),
    OVOID_MEMBER(KernelPush, end_row),
    OVOID_MEMBER(KernelPush, first_item),
    OVOID_MEMBER(KernelPush, only_sheet),
    OVOID_MEMBER(KernelPush, padding0),
    OVOID_MEMBER(KernelPush, padding1),
    OVOID_MEMBER(KernelPush, padding2),
    OVOID_MEMBER(PixelState, best),
    OVOID_MEMBER(PixelState, path),
    OVOID_MEMBER(PixelState, before),
    OVOID_MEMBER(PixelState, flags),
    OVOID_MEMBER(DepthStop, depth),
    OVOID_MEMBER(DepthStop, flags),
    OVOID_MEMBER(DepthStop, rgba),
    OVOID_MEMBER(PixelStops, first),
    OVOID_MEMBER(PixelStops, end),
    OVOID_MEMBER(PixelStops, next),
    OVOID_MEMBER(StripConstants, num_pixels),
};

#undef OVOID_MEMBER

// Fails if a member is added, moved or padded on one side alone.
TEST(DeviceLayout, IsTheShadersOwn) {
  std::map<std::string, std::size_t> ours;
  for (const Member& member : kMembers) ours[member.name] = member.offset;
  std::set<std::string> seen;
  for (std::size_t s = 0; s < kNumStages; ++s) {
    const Shader& shader = shader_of(static_cast<Stage>(s));
    for (const auto& [name, offset] : reflect(shader.code).offsets) {
      if (!ours.contains(name)) {
        // Of the blocks that hold them, whose one member begins with them.
        EXPECT_EQ(offset, 0U) << shader.name << ": " << name;
        continue;
      }
      seen.insert(name);
      EXPECT_EQ(offset, ours[name]) << shader.name << ": " << name;
    }
  }
  for (const Member& member : kMembers)
    EXPECT_TRUE(seen.contains(member.name)) << member.name << " is in no shader's buffer";
}

// Fails if a stage is given more or fewer buffers than its shader reads, or groups that devices
// need not have.
TEST(DeviceLayout, StagesHaveTheirBindings) {
  for (std::size_t s = 0; s < kNumStages; ++s) {
    const Shader& shader = shader_of(static_cast<Stage>(s));
    const Reflection found = reflect(shader.code);
    ASSERT_FALSE(found.bindings.empty()) << shader.name;
    // What a stage shares with others and does not read is gone where shaders are optimised.
    EXPECT_LE(found.bindings.size(), shader.num_bindings) << shader.name;
    EXPECT_EQ(*found.bindings.rbegin() + 1, shader.num_bindings) << shader.name;
    EXPECT_LE(shader.num_bindings, kMaxBindings) << shader.name;
    EXPECT_LE(shader.push_bytes, kPushBytes) << shader.name;
    EXPECT_GT(found.group_size, 0U) << shader.name;
    EXPECT_LE(found.group_size, kMostInvocations) << shader.name;
  }
}

}  // namespace layout_test
}  // namespace ovoid::vulkan
