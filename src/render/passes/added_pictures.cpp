// SPDX-License-Identifier: Apache-2.0
#include "render/passes/added_pictures.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>

namespace ovoid {
namespace {

void add_stages(const FrameProfile& other, FrameProfile& sum) {
  for (const auto& more : other.stages_ms) {
    const auto found = std::find_if(sum.stages_ms.begin(), sum.stages_ms.end(),
                                    [&](const auto& stage) { return stage.first == more.first; });
    if (found == sum.stages_ms.end())
      sum.stages_ms.push_back(more);
    else
      found->second += more.second;
  }
}

}  // namespace

void add_picture(const Image& other, Image& sum) {
  for (std::size_t i = 0; i < sum.rgba.size(); ++i) sum.rgba[i] += other.rgba[i];
  for (std::size_t i = 0; i < sum.depth.size(); ++i) {
    sum.depth[i] = std::min(sum.depth[i], other.depth[i]);
    sum.front_depth[i] = std::min(sum.front_depth[i], other.front_depth[i]);
  }
}

void finish_sum(Mixing mixing, Image& sum) {
  for (std::size_t i = 0; i < sum.rgba.size(); i += 4) {
    const float opacity = sum.rgba[i + 3];
    const float scale = mixing == Mixing::kAveraged && opacity > 1 ? 1 / opacity : 1;
    for (std::size_t c = 0; c < 4; ++c) sum.rgba[i + c] = std::min(scale * sum.rgba[i + c], 1.0F);
  }
}

void add_work(const FrameProfile& other, FrameProfile& sum) {
  add_stages(other, sum);
  sum.frame_ms += other.frame_ms;
  sum.kernels_total += other.kernels_total;
  sum.kernels_drawn += other.kernels_drawn;
  sum.kernels_loaded += other.kernels_loaded;
  sum.samples_reconstructed += other.samples_reconstructed;
  sum.samples_shaded += other.samples_shaded;
  sum.base_samples += other.base_samples;
  sum.gradients += other.gradients;
  sum.multiply_adds += other.multiply_adds;
  sum.bytes_loaded += other.bytes_loaded;
  sum.bytes_uploaded += other.bytes_uploaded;
  sum.blocks_total += other.blocks_total;
  sum.blocks_drawn += other.blocks_drawn;
  sum.blocks_skipped_empty += other.blocks_skipped_empty;
  sum.blocks_skipped_irrelevant += other.blocks_skipped_irrelevant;
  sum.blocks_skipped_opaque += other.blocks_skipped_opaque;
  if (sum.notice.empty()) sum.notice = other.notice;
}

}  // namespace ovoid
