// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/kernel_constants.h"

#include <algorithm>
#include <array>
#include <limits>

#include "render/shared/filters.h"

namespace ovoid::vulkan {

std::uint32_t set_flags(const KernelField& field, const view::KernelPlan& plan,
                        const RenderOptions& options, bool has_levels) {
  std::uint32_t flags = 0;
  const auto set = [&](bool is_set, std::uint32_t flag) { flags |= is_set ? flag : 0; };
  set(field.source().shape() == KernelShape::kEllipsoids, device::kHasEllipsoids);
  set(field.reconstruction() == Reconstruction::kSum, device::kSetIsSum);
  set(plan.is_mean, device::kSetTakesMeans);
  set(field.has_own_color(), device::kSetHasColor);
  set(has_levels, device::kHasLevels);
  set(options.evaluate == Evaluate::kGather, device::kIsFragmentCentric);
  set(plan.space.is_parallel, device::kSetIsParallel);
  set(field.reconstruction() == Reconstruction::kSum && has_levels &&
          options.post_convolution == PostConvolution::kAuto,
      device::kSetFindsCover);
  return flags;
}

std::uint32_t profile_number(KernelProfile profile) {
  switch (profile) {
    case KernelProfile::kGaussian:
      return device::kProfileGaussian;
    case KernelProfile::kCubicSpline:
      return device::kProfileCubicSpline;
    case KernelProfile::kWendlandC2:
      return device::kProfileWendland;
    case KernelProfile::kEpanechnikov:
      break;
  }
  return device::kProfileEpanechnikov;
}

std::uint32_t num_channels(const KernelField& field) {
  const std::uint32_t color = field.has_own_color() ? 1 : 0;
  return field.reconstruction() == Reconstruction::kSum ? 1 + color : 2 + color;
}

void set_space(device::KernelFrame& frame, const view::KernelPlan& plan) {
  const view::SplatSpace& space = plan.space;
  for (int r = 0; r < 3; ++r) {
    const Vec3 row = space.rotation.row(r);
    frame.rotation[r] = {static_cast<float>(row[0]), static_cast<float>(row[1]),
                         static_cast<float>(row[2]), 0};
  }
  frame.pitch = static_cast<float>(space.pitch);
  frame.sampling_distance = static_cast<float>(space.sampling_distance);
  frame.focal_depth = static_cast<float>(space.focal_depth);
  frame.first_depth = static_cast<float>(space.first_depth);
  frame.center_x = static_cast<float>(space.center_x);
  frame.center_y = static_cast<float>(space.center_y);
  frame.near_depth = static_cast<float>(
      std::max(plan.lattice.near_depth(), -static_cast<double>(std::numeric_limits<float>::max())));
}

void set_taps(device::KernelFrame& frame, PostConvolution how) {
  std::array<float, 12> taps{};
  for (std::size_t phase = 0; phase < 2; ++phase) {
    const FilterTaps weights = filter_taps(how, phase == 0 ? 0.25 : 0.75);
    for (std::size_t k = 0; k < weights.size(); ++k)
      taps[6 * phase + k] = static_cast<float>(weights[k]);
  }
  for (std::size_t i = 0; i < 3; ++i)
    frame.taps[i] = {taps[4 * i], taps[4 * i + 1], taps[4 * i + 2], taps[4 * i + 3]};
}

}  // namespace ovoid::vulkan
