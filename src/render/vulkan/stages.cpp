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
constexpr std::uint32_t kLatticeNodesWords[] = {
#include "lattice_nodes.inc"
};
constexpr std::uint32_t kProjectWords[] = {
#include "project.inc"
};
constexpr std::uint32_t kScanWords[] = {
#include "scan.inc"
};
constexpr std::uint32_t kScanAddWords[] = {
#include "scan_add.inc"
};
constexpr std::uint32_t kListWords[] = {
#include "list.inc"
};
constexpr std::uint32_t kSortCountWords[] = {
#include "sort_count.inc"
};
constexpr std::uint32_t kSortScatterWords[] = {
#include "sort_scatter.inc"
};
constexpr std::uint32_t kListEndsWords[] = {
#include "list_ends.inc"
};
constexpr std::uint32_t kReconstructWords[] = {
#include "reconstruct.inc"
};
constexpr std::uint32_t kShadeSheetsWords[] = {
#include "shade_sheets.inc"
};
constexpr std::uint32_t kLastStopsWords[] = {
#include "last_stops.inc"
};

constexpr std::array<Shader, kNumStages> kShaders = {{
    {"distance", kDistanceWords, 2, sizeof(device::DistanceConstants)},
    {"lattice", kLatticeWords, 12, sizeof(device::BoxConstants), true},
    {"lattice_nodes", kLatticeNodesWords, 12, sizeof(device::BoxConstants), true},
    {"project", kProjectWords, 7, sizeof(device::KernelPush), true},
    {"scan", kScanWords, 2, sizeof(device::KernelPush)},
    {"scan_add", kScanAddWords, 2, sizeof(device::KernelPush)},
    {"list", kListWords, 5, sizeof(device::KernelPush), true},
    {"sort_count", kSortCountWords, 2, sizeof(device::KernelPush)},
    {"sort_scatter", kSortScatterWords, 3, sizeof(device::KernelPush)},
    {"list_ends", kListEndsWords, 2, sizeof(device::KernelPush)},
    {"reconstruct", kReconstructWords, 10, sizeof(device::KernelPush), true},
    {"shade_sheets", kShadeSheetsWords, 12, sizeof(device::KernelPush), true},
    {"last_stops", kLastStopsWords, 6, sizeof(device::StripConstants), true},
}};

}  // namespace

const Shader& shader_of(Stage stage) { return kShaders[static_cast<std::size_t>(stage)]; }

}  // namespace ovoid::vulkan
