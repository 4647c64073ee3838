// SPDX-License-Identifier: Apache-2.0
#include "io/core/work_done.h"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <utility>

namespace ovoid::io {
namespace {

std::atomic<std::int64_t> untold_work{0};
std::mutex listener_mutex;
std::function<void(std::int64_t)> work_listener;

}  // namespace

void add_work_done(std::int64_t num_bytes) {
  const std::int64_t more = std::max<std::int64_t>(num_bytes, 0);
  if (untold_work.fetch_add(more, std::memory_order_relaxed) + more < kWorkTold) return;
  const std::lock_guard lock(listener_mutex);
  const std::int64_t untold = untold_work.exchange(0);
  if (work_listener && untold > 0) work_listener(untold);
}

void set_work_listener(std::function<void(std::int64_t num_bytes)> listener) {
  const std::lock_guard lock(listener_mutex);
  untold_work = 0;
  work_listener = std::move(listener);
}

}  // namespace ovoid::io
