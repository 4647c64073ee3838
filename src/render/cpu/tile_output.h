// SPDX-License-Identifier: Apache-2.0
// What becomes of finished tiles: pixels, reports and counts.
#pragma once

#include <chrono>
#include <memory>
#include <mutex>
#include <vector>

#include "data/out_of_memory.h"
#include "render/cpu/block.h"

namespace ovoid::cpu {

using Clock = std::chrono::steady_clock;
double ms_since(Clock::time_point start);

// A picture of the size asked for in which nothing is drawn yet. Throws Error(kOutOfMemory).
Image empty_image(int width, int height);

// One for each worker. Throws Error(kOutOfMemory).
template <typename Workspace>
std::vector<std::unique_ptr<Workspace>> make_workspaces(int num_workers) {
  const auto count = static_cast<std::size_t>(num_workers);
  return data::allocated("the working memory of the threads", count * sizeof(Workspace), [&] {
    std::vector<std::unique_ptr<Workspace>> workspaces(count);
    for (auto& workspace : workspaces) workspace = std::make_unique<Workspace>();
    return workspaces;
  });
}

// Rectangles of `edge` x `edge` pixels that cover the picture, row by row; the last ones smaller.
std::vector<TileRect> tiles_of(int width, int height, int edge);

// Stage "finish": a tile's state becomes pixels, of those named by `wanted`, row after row; null:
// all.
void finish_tile(const CpuFrame& frame, const Look& look, const TileState& tile,
                 const TileRect& rect, const RowWord* wanted, Image& image);

// Reports tiles one at a time, whatever the number of workers.
class Watch {
 public:
  // `first`: of the progress, what is done before.
  Watch(const RenderHooks& hooks, std::size_t num_tiles, double first = 0.0)
      : hooks_(hooks), num_tiles_(num_tiles), first_(first) {}
  void tile_done(const TileRect& rect, const Image& image) {
    if (!hooks_.progress && !hooks_.tile_done) return;
    const std::lock_guard lock(mutex_);
    ++done_;
    if (hooks_.tile_done) hooks_.tile_done({rect.x0, rect.y0, rect.x1, rect.y1, &image});
    if (hooks_.progress)
      hooks_.progress(first_ +
                      (1 - first_) * static_cast<double>(done_) / static_cast<double>(num_tiles_));
  }

 private:
  const RenderHooks& hooks_;
  std::size_t num_tiles_;
  double first_;
  std::size_t done_ = 0;
  std::mutex mutex_;
};

// Adds time to a stage of a profile.
void add_stage(FrameProfile& profile, const char* name, double ms);

// Adds up what the workers counted; `ticks_per_ms` 0: without times.
void add_worker_stats(const WorkerStats& stats, double ticks_per_ms, FrameProfile& profile);

}  // namespace ovoid::cpu
