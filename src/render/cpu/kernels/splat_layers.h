// SPDX-License-Identifier: Apache-2.0
// Where splats lie on a layer of blocks.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "render/cpu/kernels/splat.h"

namespace ovoid::cpu {

// Of one layer of blocks: its sheets (and their slabs, of means), and the least and greatest scale
// on them.
struct Layer {
  float first, last;
  float scale_lo, scale_hi;
};

inline std::vector<Layer> layers_of(const view::KernelPlan& plan) {
  const double reach = plan.is_mean ? 0.5 : 0.0;
  std::vector<Layer> layers;
  for (int n = 0; n < plan.num_blocks[2]; ++n) {
    const double first = n * view::kBlockDepth - reach;
    const double last = (n + 1) * view::kBlockDepth - 1 + reach;
    const double near_depth = plan.lattice.near_depth();
    const double nearest = std::max(plan.space.depth_of(first), near_depth);
    const double farthest = std::max(plan.space.depth_of(last), near_depth);
    layers.push_back({static_cast<float>(first), static_cast<float>(last),
                      static_cast<float>(plan.space.scale(farthest)),
                      static_cast<float>(plan.space.scale(nearest))});
  }
  return layers;
}

// Pixels of the picture that a splat reaches on a layer. Empty: lo_x > hi_x.
struct SplatExtent {
  float lo_x = 0, hi_x = -1, lo_y = 0, hi_y = -1;
  bool is_empty() const noexcept { return lo_x > hi_x; }
};

inline SplatExtent extent_on(const view::KernelPlan& plan, const Layer& layer, const Splat& splat) {
  const float reach = plan.is_mean ? 0.5F : 0.0F;
  const float t0 = std::max(splat.s - splat.reach_s - reach, layer.first) - splat.s;
  const float t1 = std::min(splat.s + splat.reach_s + reach, layer.last) - splat.s;
  if (t0 > t1) return {};
  // The cut is widest where it is nearest to the centre.
  float width = 1.0F;
  if (!plan.is_mean && (t0 > 0 || t1 < 0)) {
    const float share = (t0 > 0 ? t0 : t1) / splat.reach_s;
    width = std::sqrt(std::max(0.0F, 1.0F - share * share)) + 1e-3F;
  }
  const float beyond = static_cast<float>(plan.overshoot) * splat.minor;
  const auto center_x = static_cast<float>(plan.space.center_x);
  const auto center_y = static_cast<float>(plan.space.center_y);
  const auto low = [&](float at, float slope, float extent) {
    const float lo = at + std::min(slope * t0, slope * t1) - extent * width - beyond;
    return lo * (lo < 0 ? layer.scale_hi : layer.scale_lo);
  };
  const auto high = [&](float at, float slope, float extent) {
    const float hi = at + std::max(slope * t0, slope * t1) + extent * width + beyond;
    return hi * (hi > 0 ? layer.scale_hi : layer.scale_lo);
  };
  return {center_x + low(splat.x, splat.mx, splat.reach_x),
          center_x + high(splat.x, splat.mx, splat.reach_x),
          center_y + low(splat.y, splat.my, splat.reach_y),
          center_y + high(splat.y, splat.my, splat.reach_y)};
}

}  // namespace ovoid::cpu
