// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>

namespace ovoid::data {

// How much work there is and who does it.
struct ParallelPlan {
  std::int64_t count = 0;  // items 0 to count - 1
  std::int64_t grain = 1;  // items handed out at a time, >= 1
  int threads = 0;         // as resolve_threads() takes it
  // Triggered: Error(kCancelled) once the ranges under way are done, even if they are the last.
  std::stop_token stop{};
};

// 0: one per hardware thread. Throws Error(kInvalidArgument) for a negative number or more than
// kMaxThreads.
int resolve_threads(int threads);
inline constexpr int kMaxThreads = 1024;

// Calls body(begin, end) for ranges of at most `grain` items that together cover the plan, from
// several threads, the caller's among them, and returns when all are done. Which thread takes which
// range is not fixed: ranges must not share anything they write. The first exception of a body is
// rethrown here, after all threads have ended. Works with fewer threads where the system grants no
// more.
void parallel_ranges(const ParallelPlan& plan,
                     const std::function<void(std::int64_t begin, std::int64_t end)>& body);

}  // namespace ovoid::data
