// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/kernels/visible_sums.h"

#include <algorithm>
#include <array>
#include <limits>

#include "render/cpu/kernels/splat_layers.h"

namespace ovoid::cpu {
namespace {

constexpr int kCell = 8;                                      // pixels
constexpr std::size_t kCells = view::kBlockEdge / kCell + 2;  // samples begin before the pixels
constexpr int kTask = 64;                                     // blocks
constexpr std::size_t kMostSplats = 1024;  // blocks of more can show; to look closer costs more

constexpr ValueRange kAnything = {-std::numeric_limits<float>::max(),
                                  std::numeric_limits<float>::max()};

// The sums of the positive and of the negative heights that reach a cell.
struct Heights {
  std::array<float, kCells * kCells> positive{}, negative{};
};

std::size_t cell_of(float pixel, int tile) {
  constexpr float kSlack = 1e-2F;
  const float at = (pixel - static_cast<float>(tile)) / kCell + 1.0F;
  return static_cast<std::size_t>(std::clamp(at + kSlack, 0.0F, static_cast<float>(kCells - 1)));
}

// Bounds of the sum on a block; 0 is within them.
ValueRange bounds_on_block(const view::KernelPlan& plan, const Layer& layer, int tile_x, int tile_y,
                           const BinnedSplats& binned, std::span<const std::uint32_t> indices) {
  if (indices.size() > kMostSplats) return kAnything;
  Heights heights;
  for (const std::uint32_t index : indices) {
    const Splat& splat = binned.splats[index];
    const float height = splat.weight * splat.value;
    const SplatExtent extent = extent_on(plan, layer, splat);
    if (extent.is_empty()) continue;
    auto& sums = height > 0 ? heights.positive : heights.negative;
    const std::size_t x0 = cell_of(extent.lo_x - 0.2F, tile_x), x1 = cell_of(extent.hi_x, tile_x);
    const std::size_t y0 = cell_of(extent.lo_y - 0.2F, tile_y), y1 = cell_of(extent.hi_y, tile_y);
    for (std::size_t y = y0; y <= y1; ++y) {
      for (std::size_t x = x0; x <= x1; ++x) sums[y * kCells + x] += height;
    }
  }
  constexpr float kSlack = 1.02F;  // rounding, and the overshoot of post-convolution
  return {kSlack * *std::min_element(heights.negative.begin(), heights.negative.end()),
          kSlack * *std::max_element(heights.positive.begin(), heights.positive.end())};
}

}  // namespace

std::vector<std::uint8_t> visible_sums(const view::KernelPlan& plan, const BinnedSplats& binned,
                                       Runner& runner) {
  const std::vector<Layer> layers = layers_of(plan);
  const auto count = static_cast<std::size_t>(plan.total_blocks());
  const std::size_t per_layer = static_cast<std::size_t>(plan.num_blocks[0]) * plan.num_blocks[1];
  std::vector<ValueRange> bounds(count, ValueRange{0, 0});
  runner.run(static_cast<int>((count + kTask - 1) / kTask), [&](int task, int) {
    const std::size_t first = static_cast<std::size_t>(task) * kTask;
    for (std::size_t block = first; block < std::min(count, first + kTask); ++block) {
      if (plan.is_needed[block] == 0) continue;
      const auto in_layer = static_cast<int>(block % per_layer);
      bounds[block] = bounds_on_block(
          plan, layers[block / per_layer], in_layer % plan.num_blocks[0] * view::kBlockEdge,
          in_layer / plan.num_blocks[0] * view::kBlockEdge, binned, binned.of_block(block));
    }
  });
  std::vector<std::uint8_t> is_visible = plan.is_relevant;
  for (std::size_t block = 0; block < count; ++block) {
    if (is_visible[block] == 0) continue;
    ValueRange all = bounds[block];
    // A piece begins, and a crossing may, in the block before.
    if (block >= per_layer) {
      all.lo = std::min(all.lo, bounds[block - per_layer].lo);
      all.hi = std::max(all.hi, bounds[block - per_layer].hi);
    }
    is_visible[block] = plan.may_matter(all.lo, all.hi) ? 1 : 0;
  }
  return is_visible;
}

}  // namespace ovoid::cpu
