// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/lattice/warp.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/cpu/lattice/warp.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "render/cpu/lattice/warp-inl.h"

#if HWY_ONCE

namespace ovoid::cpu {

HWY_EXPORT(warp_on_target);

namespace {

constexpr int kStripRows = 16;
constexpr double kReach = 2.0;  // of the filter, samples or pixels

}  // namespace

BasePicture::BasePicture(Image picture, Runner& runner)
    : image(std::move(picture)),
      tiles_across(static_cast<std::size_t>((image.width + kSpotSize - 1) / kSpotSize)),
      tiles(tiles_across * static_cast<std::size_t>((image.height + kSpotSize - 1) / kSpotSize)) {
  runner.run((image.height + kSpotSize - 1) / kSpotSize, [&](int tile_row, int) {
    const int last = std::min((tile_row + 1) * kSpotSize, image.height);
    for (int y = tile_row * kSpotSize; y < last; ++y) {
      for (int x = 0; x < image.width; ++x) {
        const std::size_t sample = static_cast<std::size_t>(y) * image.width + x;
        const float* const rgba = image.rgba.data() + 4 * sample;
        const bool is_empty = rgba[0] == 0 && rgba[1] == 0 && rgba[2] == 0 && rgba[3] == 0 &&
                              std::isinf(image.depth[sample]);
        if (is_empty) continue;
        tiles[static_cast<std::size_t>(tile_row) * tiles_across +
              static_cast<std::size_t>(x / kSpotSize)] = 1;
        x += kSpotSize - x % kSpotSize - 1;  // this row says no more of the tile
      }
    }
  });
}

bool is_seen(const view::BasePlane& base, const TileRect& tile) {
  Eigen::AlignedBox2d box;
  for (const double x : {tile.x0 - kReach - 1, tile.x1 + kReach}) {
    for (const double y : {tile.y0 - kReach - 1, tile.y1 + kReach}) {
      if ((base.picture_from_base.matrix * Vec3(x, y, 1))[2] <= 0) return true;
      box.extend(base.picture_from_base(x, y));
    }
  }
  // Of pixels that are wider than samples the filter reaches as many pixels.
  return box.max().minCoeff() >= -kReach && box.min()[0] <= base.picture_width - 1 + kReach &&
         box.min()[1] <= base.picture_height - 1 + kReach;
}

std::vector<TileRect> strips_of(const RenderOptions& options) {
  std::vector<TileRect> strips;
  for (int y = 0; y < options.height; y += kStripRows)
    strips.push_back({0, y, options.width, std::min(y + kStripRows, options.height)});
  return strips;
}

void warp(const simd::SimdTarget& target, const WarpJob& job, const TileRect& strip,
          Image& picture) {
  target.choose(HWY_DISPATCH_TABLE(warp_on_target))(job, strip, picture);
}

}  // namespace ovoid::cpu
#endif
