// SPDX-License-Identifier: Apache-2.0
#include "render/passes/picture_tiles.h"

#include "data/parallel.h"
#include "render/teller.h"

namespace ovoid {

void paint_tiles(int num_tiles, int threads, const RenderHooks& hooks,
                 const std::function<void(int tile)>& paint) {
  Teller teller(hooks, num_tiles);
  data::parallel_ranges({num_tiles, 1, threads, hooks.stop},
                        [&](std::int64_t begin, std::int64_t end) {
                          for (auto tile = static_cast<int>(begin); tile < end; ++tile) paint(tile);
                          teller.done(end - begin);
                        });
}

}  // namespace ovoid
