// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/runner.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <numeric>
#include <optional>
#include <random>
#include <thread>
#include <vector>

#include "ovoid/error.h"

#ifdef OVOID_TBB
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#endif

namespace ovoid::cpu {
namespace {

// The first exception of any worker.
class FirstError {
 public:
  void capture() noexcept {
    const std::lock_guard lock(mutex_);
    if (!error_) error_ = std::current_exception();
    has_error_ = true;
  }
  bool is_set() const noexcept { return has_error_; }
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  std::mutex mutex_;
  std::exception_ptr error_;
  std::atomic<bool> has_error_{false};
};

class ThreadRunner final : public Runner {
 public:
  explicit ThreadRunner(int num_threads) : num_threads_(num_threads) {}
  int num_workers() const noexcept override { return num_threads_; }
  void run(int num_tasks, const Task& task) override {
    std::atomic<int> next{0};
    FirstError error;
    const auto work = [&](int worker) {
      for (int i = next++; i < num_tasks && !error.is_set(); i = next++) {
        try {
          task(i, worker);
        } catch (...) {
          error.capture();
        }
      }
    };
    std::vector<std::jthread> threads;
    const int extra = std::max(std::min(num_threads_, num_tasks) - 1, 0);
    threads.reserve(static_cast<std::size_t>(extra));
    for (int t = 0; t < extra; ++t) threads.emplace_back(work, t + 1);
    work(0);
    threads.clear();
    error.rethrow();
  }

 private:
  int num_threads_;
};

class ShuffleRunner final : public Runner {
 public:
  int num_workers() const noexcept override { return 1; }
  void run(int num_tasks, const Task& task) override {
    std::vector<int> order(static_cast<std::size_t>(num_tasks));
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), random_);
    for (const int i : order) task(i, 0);
  }

 private:
  std::mt19937 random_{20061};
};

#ifdef OVOID_TBB
class TbbRunner final : public Runner {
 public:
  explicit TbbRunner(int num_threads) : arena_(num_threads), num_threads_(num_threads) {
    // More threads than the machine has must be allowed first, else TBB refuses them, and says so
    // on standard error. Never less: the least control of a process holds for all its arenas.
    if (num_threads > tbb::info::default_concurrency()) {
      more_threads_.emplace(tbb::global_control::max_allowed_parallelism, num_threads);
    }
  }
  int num_workers() const noexcept override { return num_threads_; }
  void run(int num_tasks, const Task& task) override {
    arena_.execute([&] {
      tbb::parallel_for(
          0, num_tasks, [&](int i) { task(i, tbb::this_task_arena::current_thread_index()); },
          tbb::simple_partitioner());
    });
  }

 private:
  std::optional<tbb::global_control> more_threads_;
  tbb::task_arena arena_;
  int num_threads_;
};
#endif

}  // namespace

std::unique_ptr<Runner> make_runner(const std::string& kind, int num_threads) {
  if (num_threads <= 0)
    num_threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  if (kind == "threads") return std::make_unique<ThreadRunner>(num_threads);
  if (kind == "shuffle") return std::make_unique<ShuffleRunner>();
#ifdef OVOID_TBB
  if (kind == "tbb" || kind.empty()) return std::make_unique<TbbRunner>(num_threads);
#else
  if (kind.empty()) return std::make_unique<ThreadRunner>(num_threads);
#endif
  throw Error(
      ErrorCode::kInvalidArgument,
      fmt::format("OVOID_RUNNER = {}: must be tbb (if built in), threads or shuffle", kind));
}

std::unique_ptr<Runner> make_runner(int num_threads) {
  const char* kind = std::getenv("OVOID_RUNNER");
  return make_runner(kind == nullptr ? "" : kind, num_threads);
}

}  // namespace ovoid::cpu
