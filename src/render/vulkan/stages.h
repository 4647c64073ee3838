// SPDX-License-Identifier: Apache-2.0
// The stages that run on the device, a shader each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace ovoid::vulkan {

enum class Stage {
  kDistance,      // of bricks to what can show, along one axis
  kLattice,       // reconstruct, shade, composite
  kLatticeNodes,  // the same with post-convolve before shade
  kProject,       // kernels -> splats
  kScan,          // sums of what lies before, block by block
  kScanAdd,       // and of the blocks before
  kList,          // splats -> (list, splat) pairs
  kSortCount,     // of each digit per block of pairs
  kSortScatter,   // pairs to their places
  kListEnds,      // where each list begins and ends
  kReconstruct,   // splats -> a level's sheets, with what coarser levels have
  kShade,         // sheets -> colour and opacity, composited
  kLastStops,     // of depth limits: what stands behind all that was drawn
  kNumStages,
};
inline constexpr std::size_t kNumStages = static_cast<std::size_t>(Stage::kNumStages);

// What every device must have for them.
inline constexpr std::uint32_t kMaxBindings = 12;
inline constexpr std::uint32_t kSharedBytes = 32768;
inline constexpr std::uint32_t kMostInvocations = 256;
inline constexpr std::uint32_t kPushBytes = 128;

struct Shader {
  const char* name;  // of the file, and in profiles
  std::span<const std::uint32_t> code;
  std::uint32_t num_bindings;  // buffers at 0, 1, ... of set 0
  std::uint32_t push_bytes;
  // Binding 0 is the frame's constants, a uniform buffer: processors read those fastest. The others
  // are storage buffers.
  bool has_frame = false;
};

const Shader& shader_of(Stage stage);

}  // namespace ovoid::vulkan
