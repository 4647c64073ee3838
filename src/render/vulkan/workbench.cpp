// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/workbench.h"

#include <array>
#include <vector>

namespace ovoid::vulkan {

void tell_of(const Strip& strip, const RenderHooks& hooks, const Image& image) {
  if (hooks.tile_done) hooks.tile_done({0, strip.first, image.width, strip.end, &image});
  if (hooks.progress)
    hooks.progress(static_cast<double>(strip.end) / static_cast<double>(image.height));
}

void add_counts(Commands& commands, const Buffer& counts, std::size_t num_groups,
                FrameProfile& profile) {
  std::vector<std::array<std::uint32_t, 4>> of_groups(num_groups);
  commands.read_back(counts, 0, std::as_writable_bytes(std::span(of_groups)));
  for (const auto& [reconstructed, shaded, gradients, unused] : of_groups) {
    profile.samples_reconstructed += reconstructed;
    profile.samples_shaded += shaded;
    profile.gradients += gradients;
  }
}

}  // namespace ovoid::vulkan
