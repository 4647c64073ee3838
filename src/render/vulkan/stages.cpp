// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/stages.h"

#include <array>

#include "render/shared/device_layout.h"

namespace ovoid::vulkan {
namespace {

constexpr std::uint32_t kDistanceWords[] = {
#include "distance.inc"
};
constexpr std::uint32_t kLatticeWords[] = {
#include "lattice.inc"
};

constexpr std::array<Shader, kNumStages> kShaders = {{
    {"distance", kDistanceWords, 2, sizeof(device::DistanceConstants)},
    {"lattice", kLatticeWords, 10, sizeof(device::BoxConstants)},
}};

}  // namespace

const Shader& shader_of(Stage stage) { return kShaders[static_cast<std::size_t>(stage)]; }

}  // namespace ovoid::vulkan
