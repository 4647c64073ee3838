// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <mutex>

#include "ovoid/renderer.h"

namespace ovoid {

// Tells a frame's hooks of finished parts, one at a time, whatever the number of threads. After a
// hook has thrown, what it threw is on its way to render()'s caller, and no hook is called again.
class Teller {
 public:
  // `first`: of the progress, what is done before.
  Teller(const RenderHooks& hooks, std::int64_t num_parts, double first = 0.0)
      : hooks_(hooks), num_parts_(num_parts), first_(first) {}

  // A part that is a rectangle of the picture. Throws what a hook throws.
  void done(const TileDone& tile) { tell(1, &tile); }
  // Parts without a picture.
  void done(std::int64_t parts) { tell(parts, nullptr); }

 private:
  void tell(std::int64_t parts, const TileDone* tile) {
    if (!hooks_.progress && !hooks_.tile_done) return;
    const std::lock_guard lock(mutex_);
    if (has_thrown_) return;
    num_done_ += parts;
    has_thrown_ = true;  // unless the end is reached
    if (tile != nullptr && hooks_.tile_done) hooks_.tile_done(*tile);
    if (hooks_.progress) {
      const double share = static_cast<double>(num_done_) / static_cast<double>(num_parts_);
      hooks_.progress(first_ + (1 - first_) * share);
    }
    has_thrown_ = false;
  }

  const RenderHooks& hooks_;
  const std::int64_t num_parts_;
  const double first_;
  std::mutex mutex_;  // guards the rest, and the hooks
  std::int64_t num_done_ = 0;
  bool has_thrown_ = false;
};

}  // namespace ovoid
