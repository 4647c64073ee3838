// SPDX-License-Identifier: Apache-2.0
// What pictures of surfaces and of points share: square tiles that are independent of each other,
// each with a list of what may be seen in it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "ovoid/renderer.h"

namespace ovoid {

struct PictureExtent {  // pixels from the left and the top
  double left, right, top, bottom;
};

class TileLists {
 public:
  static constexpr int kTile = 32;  // pixels along a tile's side

  TileLists(int width, int height)
      : width_(width),
        height_(height),
        across_((width + kTile - 1) / kTile),
        down_((height + kTile - 1) / kTile) {}

  int num_tiles() const noexcept { return across_ * down_; }
  // First pixel of a tile.
  int tile_x(int tile) const noexcept { return tile % across_ * kTile; }
  int tile_y(int tile) const noexcept { return tile / across_ * kTile; }

  // Lists each of `count` things in the tiles that extent_of(its number) touches; what is not a
  // number touches none.
  template <class ExtentOf>
  void assign(std::uint32_t count, const ExtentOf& extent_of) {
    const auto for_tiles = [&](std::uint32_t thing, const auto& visit) {
      const PictureExtent extent = extent_of(thing);
      const bool touches =
          extent.right >= 0 && extent.bottom >= 0 && extent.left <= width_ && extent.top <= height_;
      if (!touches) return;
      const auto tile_at = [](double place, int num) {
        return static_cast<int>(std::clamp(std::floor(place / kTile), 0.0, num - 1.0));
      };
      for (int y = tile_at(extent.top, down_); y <= tile_at(extent.bottom, down_); ++y) {
        for (int x = tile_at(extent.left, across_); x <= tile_at(extent.right, across_); ++x)
          visit(static_cast<std::size_t>(y) * static_cast<std::size_t>(across_) +
                static_cast<std::size_t>(x));
      }
    };
    first_.assign(static_cast<std::size_t>(num_tiles()) + 1, 0);
    for (std::uint32_t i = 0; i < count; ++i)
      for_tiles(i, [&](std::size_t tile) { ++first_[tile + 1]; });
    for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    things_.resize(first_.back());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t i = 0; i < count; ++i)
      for_tiles(i, [&](std::size_t tile) { things_[next[tile]++] = i; });
  }

  // Rising.
  std::span<const std::uint32_t> of_tile(int tile) const {
    const auto at = static_cast<std::size_t>(tile);
    return {things_.data() + first_[at], things_.data() + first_[at + 1]};
  }

 private:
  int width_, height_, across_, down_;
  std::vector<std::uint32_t> first_, things_;
};

// Calls paint(tile) for every tile, from several threads, and tells of progress. Throws
// Error(kCancelled).
void paint_tiles(int num_tiles, int threads, const RenderHooks& hooks,
                 const std::function<void(int tile)>& paint);

}  // namespace ovoid
