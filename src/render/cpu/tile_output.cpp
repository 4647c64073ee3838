// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/tile_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "data/lattice/large_pages.h"
#include "view/plan/finished_pixel.h"

namespace ovoid::cpu {

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

Image empty_image(int width, int height) {
  Image image;
  image.width = width;
  image.height = height;
  const std::size_t num_pixels = static_cast<std::size_t>(width) * height;
  data::allocated(fmt::format("a picture of {} x {} pixels", width, height),
                  6 * sizeof(float) * num_pixels, [&] {
                    data::reserve_large_pages(image.rgba, 4 * num_pixels);
                    image.rgba.assign(4 * num_pixels, 0.0F);
                    for (std::vector<float>* depths : {&image.depth, &image.front_depth}) {
                      data::reserve_large_pages(*depths, num_pixels);
                      depths->assign(num_pixels, std::numeric_limits<float>::infinity());
                    }
                  });
  return image;
}

std::vector<TileRect> tiles_of(int width, int height, int edge) {
  std::vector<TileRect> tiles;
  for (int y = 0; y < height; y += edge) {
    for (int x = 0; x < width; x += edge) {
      tiles.push_back({x, y, std::min(x + edge, width), std::min(y + edge, height)});
    }
  }
  return tiles;
}

void finish_tile(const CpuFrame& frame, const Look& look, const TileState& tile,
                 const TileRect& rect, const RowWord* wanted, Image& image) {
  for (int y = rect.y0; y < rect.y1; ++y) {
    for (int x = rect.x0; x < rect.x1; ++x) {
      if (wanted != nullptr && (wanted[y - rect.y0] >> (x - rect.x0) & 1U) == 0) continue;
      const int i = (y - rect.y0) * kTileSize + (x - rect.x0);
      const std::size_t pixel = static_cast<std::size_t>(y) * image.width + x;
      float* rgba = image.rgba.data() + 4 * pixel;
      image.depth[pixel] = tile.depth[i];
      if (frame.mode == Mode::kComposite || frame.mode == Mode::kIsosurface) {
        rgba[0] = tile.red[i];
        rgba[1] = tile.green[i];
        rgba[2] = tile.blue[i];
        rgba[3] = tile.alpha[i];
        image.front_depth[pixel] = tile.front_depth[i];
        continue;
      }
      if ((tile.seen[y - rect.y0] >> (x - rect.x0) & 1U) == 0) continue;
      if (frame.options->part != nullptr) {
        keep_value(tile.best[i], tile.path[i], rgba);
      } else {
        show_value(look, tile.best[i], tile.path[i], rgba);
      }
      image.front_depth[pixel] = front_depth_of_value(rgba, tile.depth[i]);
    }
  }
}

void add_stage(FrameProfile& profile, const char* name, double ms) {
  const auto named = std::find_if(profile.stages_ms.begin(), profile.stages_ms.end(),
                                  [&](const auto& stage) { return stage.first == name; });
  if (named == profile.stages_ms.end()) {
    profile.stages_ms.emplace_back(name, ms);
  } else {
    named->second += ms;
  }
}

void add_worker_stats(const WorkerStats& stats, double ticks_per_ms, FrameProfile& profile) {
  profile.samples_reconstructed += stats.samples_reconstructed;
  profile.samples_shaded += stats.samples_shaded;
  profile.gradients += stats.gradients;
  profile.multiply_adds += static_cast<double>(stats.multiply_adds);
  profile.bytes_loaded += static_cast<double>(stats.bytes_loaded);
  profile.kernels_loaded += stats.kernels_loaded;
  profile.blocks_total += stats.blocks_total;
  profile.blocks_drawn += stats.blocks_drawn;
  profile.blocks_skipped_empty += stats.skipped_empty;
  profile.blocks_skipped_irrelevant += stats.skipped_irrelevant;
  profile.blocks_skipped_opaque += stats.skipped_opaque;
  if (ticks_per_ms <= 0) return;
  for (std::size_t i = 0; i < kNumStages; ++i)
    add_stage(profile, kStageNames[i], static_cast<double>(stats.ticks[i]) / ticks_per_ms);
}

}  // namespace ovoid::cpu
