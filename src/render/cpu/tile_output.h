// SPDX-License-Identifier: Apache-2.0
// What becomes of finished tiles: pixels, reports and counts.
#pragma once

#include <chrono>
#include <memory>
#include <vector>

#include "data/out_of_memory.h"
#include "render/cpu/lattice/block.h"
#include "render/teller.h"

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

inline TileDone told_of(const TileRect& rect, const Image& image) {
  return {rect.x0, rect.y0, rect.x1, rect.y1, &image};
}

// Rectangles of `edge` x `edge` pixels that cover the picture, row by row; the last ones smaller.
std::vector<TileRect> tiles_of(int width, int height, int edge);

// Stage "finish": a tile's state becomes pixels, of those named by `wanted`, row after row; null:
// all.
void finish_tile(const CpuFrame& frame, const Look& look, const TileState& tile,
                 const TileRect& rect, const RowWord* wanted, Image& image);

// Adds time to a stage of a profile.
void add_stage(FrameProfile& profile, const char* name, double ms);

// Adds up what the workers counted; `ticks_per_ms` 0: without times.
void add_worker_stats(const WorkerStats& stats, double ticks_per_ms, FrameProfile& profile);

}  // namespace ovoid::cpu
