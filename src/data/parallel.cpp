// SPDX-License-Identifier: Apache-2.0
#include "data/parallel.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <new>
#include <system_error>
#include <thread>
#include <vector>

#include "ovoid/error.h"

namespace ovoid::data {

int resolve_threads(int threads) {
  if (threads < 0 || threads > kMaxThreads) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("threads = {}: must be 0 (one per hardware thread) to {}", threads,
                            kMaxThreads));
  }
  if (threads > 0) return threads;
  // hardware_concurrency() is 0 where the system does not tell.
  return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, kMaxThreads);
}

void parallel_ranges(const ParallelPlan& plan,
                     const std::function<void(std::int64_t, std::int64_t)>& body) {
  std::atomic<std::int64_t> next{0};
  std::atomic<bool> failed{false};
  std::exception_ptr failure;
  std::mutex failure_mutex;

  const auto check_stop = [&] {
    if (plan.stop.stop_requested()) throw Error(ErrorCode::kCancelled, "cancelled");
  };
  const auto work = [&] {
    try {
      while (!failed.load(std::memory_order_relaxed)) {
        const std::int64_t begin = next.fetch_add(plan.grain, std::memory_order_relaxed);
        if (begin >= plan.count) return;
        check_stop();
        body(begin, std::min(begin + plan.grain, plan.count));
      }
    } catch (...) {
      const std::scoped_lock lock(failure_mutex);
      if (!failure) failure = std::current_exception();
      failed = true;
    }
  };

  const std::int64_t num_ranges = (plan.count + plan.grain - 1) / plan.grain;
  const std::int64_t num_threads =
      std::min<std::int64_t>(resolve_threads(plan.threads), num_ranges);
  {
    std::vector<std::jthread> helpers;
    try {
      for (std::int64_t i = 1; i < num_threads; ++i) helpers.emplace_back(work);
    } catch (const std::system_error&) {
      // No more threads to be had: those that started, and this one, do all the work.
    } catch (const std::bad_alloc&) {  // NOLINT(bugprone-empty-catch): likewise
    }
    work();
  }
  if (failure) std::rethrow_exception(failure);
  check_stop();  // bodies that look at the token themselves may have left their ranges unfinished
}

}  // namespace ovoid::data
