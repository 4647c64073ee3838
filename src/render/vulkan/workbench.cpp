// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/workbench.h"

#include <array>
#include <vector>

namespace ovoid::vulkan {

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
