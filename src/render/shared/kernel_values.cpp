// SPDX-License-Identifier: Apache-2.0
#include "render/shared/kernel_values.h"

#include <algorithm>
#include <array>
#include <limits>

#include "render/shared/device_vectors.h"
#include "render/shared/filters.h"

namespace ovoid {
namespace {

// Least sigma, in samples of a level, of the kernels summed on it (docs/numerics.md, "Levels"; the
// pictures' test holds what the filter then loses).
constexpr float kLeastLevelSigma = 1.6F;
constexpr float kLeastSurfaceSigma = 2.4F;  // a surface is there or not, by any error
constexpr float kPublishedLevelSigma = 0.5F;

// The filter from a level to the finer one.
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

}  // namespace

KernelTraits kernel_traits(const KernelField& field, const view::KernelPlan& plan, const Look& look,
                           const RenderOptions& options) {
  KernelTraits traits;
  traits.profile = field.source().profile();
  traits.cutoff = static_cast<float>(field.source().cutoff());
  traits.is_sum = field.reconstruction() == Reconstruction::kSum;
  traits.takes_means = plan.is_mean;
  traits.num_channels = (traits.is_sum ? 1 : 2) + (field.has_own_color() ? 1 : 0);
  traits.gathers = options.evaluate == Evaluate::kGather;
  const bool is_auto = options.post_convolution == PostConvolution::kAuto;
  traits.least_level_sigma = !is_auto                         ? kPublishedLevelSigma
                             : look.mode == Mode::kIsosurface ? kLeastSurfaceSigma
                                                              : kLeastLevelSigma;
  if (options.post_convolution == PostConvolution::kOff || traits.gathers) return traits;
  traits.max_level = device::kNumLevels - 1;
  traits.finds_cover = traits.is_sum && is_auto;
  return traits;
}

device::KernelFrame kernel_constants(const view::KernelPlan& plan, const KernelTraits& traits,
                                     PostConvolution how) {
  device::KernelFrame frame{};
  const view::SplatSpace& space = plan.space;
  for (int r = 0; r < 3; ++r) {
    const Vec3 row = space.rotation.row(r);
    frame.rotation[r] = device_vector(row);
  }
  frame.pitch = static_cast<float>(space.pitch);
  frame.sampling_distance = static_cast<float>(space.sampling_distance);
  frame.focal_depth = static_cast<float>(space.focal_depth);
  frame.first_depth = static_cast<float>(space.first_depth);
  frame.center_x = static_cast<float>(space.center_x);
  frame.center_y = static_cast<float>(space.center_y);
  frame.near_depth = static_cast<float>(
      std::max(plan.lattice.near_depth(), -static_cast<double>(std::numeric_limits<float>::max())));
  frame.cutoff = traits.cutoff;
  frame.least_pixels = static_cast<float>(view::kLeastPixels);
  frame.least_level_sigma = traits.least_level_sigma;
  frame.max_level = traits.max_level;
  if (traits.max_level > 0) set_taps(frame, how);
  return frame;
}

}  // namespace ovoid
