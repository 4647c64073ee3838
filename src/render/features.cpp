// SPDX-License-Identifier: Apache-2.0
#include "render/features.h"

#include <fmt/format.h>

#include <iterator>

#include "ovoid/error.h"
#include "render/back_end.h"

namespace ovoid {
namespace {

// By Feature; the reference, cpu, vulkan.
constexpr BackEndFeature kFeatures[] = {
    {"lattices", true, true, true},
    {"sets of kernels", true, true, true},
    {"depth limits: meshes that end at their surface, surfaces, slices, labels", true, true, true},
    {"parts of space", true, true, true},
    {"occlusion and shadows", true, true, true},
    {"trails of lattices", true, true, true},
    {"trails of sets of kernels", true, true, false},
    {"several volumes", true, true, false},
    {"several isosurfaces", true, true, false},
    {"2-D transfer functions", true, true, false},
    {"lattice sheets", true, true, false},
    {"half sheets of sets of kernels", false, false, true},
};
static_assert(std::size(kFeatures) == static_cast<std::size_t>(Feature::kHalfSheets) + 1);

const BackEndFeature& row_of(Feature feature) {
  return kFeatures[static_cast<std::size_t>(feature)];
}

}  // namespace

std::span<const BackEndFeature> back_end_features() { return kFeatures; }

bool draws(Backend by, Feature feature) {
  const BackEndFeature& row = row_of(feature);
  return by == Backend::kReference ? row.by_reference
         : by == Backend::kVulkan  ? row.by_vulkan
                                   : row.by_cpu;
}

void require_features(Backend by, const FrameJob& job) {
  const auto require = [by](bool is_used, Feature feature) {
    if (!is_used || draws(by, feature)) return;
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: not by backend {}, take cpu or auto", row_of(feature).name,
                            by == Backend::kVulkan ? "vulkan" : "reference"));
  };
  const bool is_lattice = job.field.lattice() != nullptr;
  require(is_lattice, Feature::kLattices);
  require(!is_lattice, Feature::kKernelSets);
  require(job.options.depth_limits != nullptr, Feature::kDepthLimits);
  require(job.options.part != nullptr, Feature::kParts);
  require(job.light != nullptr, Feature::kLightVolume);
  require(job.trail != nullptr && is_lattice, Feature::kTrailsOfLattices);
  require(job.trail != nullptr && !is_lattice, Feature::kTrailsOfKernelSets);
  require(!job.further.empty(), Feature::kSeveralVolumes);
  require(job.look.mode == Mode::kIsosurface && !job.look.isosurfaces.empty(),
          Feature::kSeveralIsosurfaces);
  require(job.look.transfer_function_2d.has_value(), Feature::kTransferFunction2D);
}

}  // namespace ovoid
