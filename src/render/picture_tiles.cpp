// SPDX-License-Identifier: Apache-2.0
#include "render/picture_tiles.h"

#include <mutex>

#include "data/parallel.h"

namespace ovoid {

void paint_tiles(int num_tiles, int threads, const RenderHooks& hooks,
                 const std::function<void(int tile)>& paint) {
  std::mutex telling;
  std::int64_t num_done = 0;
  data::parallel_ranges({num_tiles, 1, threads, hooks.stop},
                        [&](std::int64_t begin, std::int64_t end) {
                          for (auto tile = static_cast<int>(begin); tile < end; ++tile) paint(tile);
                          if (!hooks.progress) return;
                          const std::lock_guard lock(telling);
                          num_done += end - begin;
                          hooks.progress(static_cast<double>(num_done) / num_tiles);
                        });
}

}  // namespace ovoid
