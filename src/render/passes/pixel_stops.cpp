// SPDX-License-Identifier: Apache-2.0
#include "render/passes/pixel_stops.h"

#include <algorithm>
#include <array>

#include "data/parallel.h"

namespace ovoid {
namespace {

constexpr int kTile = SurfaceRaster::kTile;

struct TileStops {
  std::vector<DepthLimits::Stop> stops;
  std::array<std::uint32_t, kTile * kTile> count{};
};

// Calls visit(number in the tile, number in the picture) for the tile's pixels.
template <class Visit>
void for_pixels(const SurfaceRaster& raster, int tile, const Visit& visit) {
  const int x0 = raster.tile_x(tile);
  const int y0 = raster.tile_y(tile);
  for (int y = 0; y < std::min(kTile, raster.height() - y0); ++y) {
    for (int x = 0; x < std::min(kTile, raster.width() - x0); ++x)
      visit(x, y,
            static_cast<std::size_t>(y0 + y) * static_cast<std::size_t>(raster.width()) +
                static_cast<std::size_t>(x0 + x));
  }
}

std::size_t in_tile(int x, int y) {
  return static_cast<std::size_t>(y) * kTile + static_cast<std::size_t>(x);
}

}  // namespace

DepthLimits limits_of_tiles(const SurfaceRaster& raster, int threads, const std::stop_token& stop,
                            const PixelStops& stops_of) {
  DepthLimits limits;
  limits.width = raster.width();
  limits.height = raster.height();
  const std::size_t num_pixels =
      static_cast<std::size_t>(limits.width) * static_cast<std::size_t>(limits.height);
  limits.coverage.assign(num_pixels, 0.0F);
  limits.first.assign(num_pixels + 1, 0);
  const auto num_tiles = static_cast<std::size_t>(raster.num_tiles());
  std::vector<TileStops> tiles(num_tiles);
  const data::ParallelPlan plan{raster.num_tiles(), 1, threads, stop};
  data::parallel_ranges(plan, [&](std::int64_t begin, std::int64_t end) {
    for (auto tile = static_cast<int>(begin); tile < end; ++tile) {
      const auto fragments = raster.tile_fragments(tile, false);
      if (fragments.fragments.empty()) continue;
      TileStops& own = tiles[static_cast<std::size_t>(tile)];
      for_pixels(raster, tile, [&](int x, int y, std::size_t pixel) {
        const auto of_pixel = fragments.of_pixel(x, y);
        if (of_pixel.empty()) return;
        const std::size_t before = own.stops.size();
        limits.coverage[pixel] =
            stops_of(raster.tile_x(tile) + x, raster.tile_y(tile) + y, of_pixel, own.stops);
        const auto count = static_cast<std::uint32_t>(own.stops.size() - before);
        own.count[in_tile(x, y)] = count;
        limits.first[pixel + 1] = count;
      });
    }
  });
  for (std::size_t i = 0; i < num_pixels; ++i) limits.first[i + 1] += limits.first[i];
  limits.stops.resize(limits.first.back());
  data::parallel_ranges(plan, [&](std::int64_t begin, std::int64_t end) {
    for (auto tile = static_cast<int>(begin); tile < end; ++tile) {
      const TileStops& own = tiles[static_cast<std::size_t>(tile)];
      auto next = own.stops.begin();
      if (own.stops.empty()) continue;
      for_pixels(raster, tile, [&](int x, int y, std::size_t pixel) {
        const auto count = static_cast<std::ptrdiff_t>(own.count[in_tile(x, y)]);
        std::copy_n(next, count,
                    limits.stops.begin() + static_cast<std::ptrdiff_t>(limits.first[pixel]));
        next += count;
      });
    }
  });
  return limits;
}

}  // namespace ovoid
