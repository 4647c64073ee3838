// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/runner.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <new>
#include <numeric>
#include <random>
#include <system_error>
#include <thread>
#include <vector>

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

// Threads that stay from run to run, made when the first one needs them: a frame has several runs,
// and a renderer on a device has none.
class ThreadRunner final : public Runner {
 public:
  explicit ThreadRunner(int num_threads) : num_wanted_(num_threads) {}
  ~ThreadRunner() override {
    {
      const std::lock_guard lock(mutex_);
      is_over_ = true;
    }
    begin_.notify_all();
  }
  ThreadRunner(const ThreadRunner&) = delete;
  ThreadRunner& operator=(const ThreadRunner&) = delete;

  int num_wanted() const noexcept override { return num_wanted_; }
  int num_workers() override {
    std::call_once(is_started_, [this] { start(); });
    return static_cast<int>(threads_.size()) + 1;
  }
  void run(int num_tasks, const Task& task) override {
    const int num_helpers = num_workers() - 1;
    const std::lock_guard one_at_a_time(run_mutex_);
    Job job{task, num_tasks};
    if (num_helpers > 0 && num_tasks > 1) {
      {
        const std::lock_guard lock(mutex_);
        job_ = &job;
        ++job_number_;
      }
      begin_.notify_all();
    }
    job.work(0);
    {
      std::unique_lock lock(mutex_);
      job_ = nullptr;  // whoever comes now is late, and not waited for
      end_.wait(lock, [this] { return num_helping_ == 0; });
    }
    job.error.rethrow();
  }

 private:
  struct Job {
    const Task& task;
    int num_tasks;
    std::atomic<int> next{0};
    FirstError error{};

    void work(int worker) noexcept {
      for (int i = next++; i < num_tasks && !error.is_set(); i = next++) {
        try {
          task(i, worker);
        } catch (...) {
          error.capture();
        }
      }
    }
  };

  // As many as the system grants: the work is done with fewer too.
  void start() {
    try {
      threads_.reserve(static_cast<std::size_t>(num_wanted_ - 1));
      for (int t = 1; t < num_wanted_; ++t) threads_.emplace_back([this, t] { help(t); });
    } catch (const std::system_error&) {  // NOLINT(bugprone-empty-catch): num_workers() tells
    } catch (const std::bad_alloc&) {     // NOLINT(bugprone-empty-catch): likewise
    }
  }

  void help(int worker) noexcept {
    std::int64_t last = 0;
    std::unique_lock lock(mutex_);
    while (true) {
      begin_.wait(lock, [&] { return is_over_ || (job_ != nullptr && job_number_ != last); });
      if (is_over_) return;
      Job& job = *job_;
      last = job_number_;
      ++num_helping_;
      lock.unlock();
      job.work(worker);
      lock.lock();
      if (--num_helping_ == 0) end_.notify_one();
    }
  }

  const int num_wanted_;
  std::once_flag is_started_;
  std::mutex run_mutex_;
  std::mutex mutex_;  // of these
  std::condition_variable begin_, end_;
  Job* job_ = nullptr;
  std::int64_t job_number_ = 0;
  int num_helping_ = 0;
  bool is_over_ = false;
  std::vector<std::jthread> threads_;  // the last member: they use the others
};

class ShuffleRunner final : public Runner {
 public:
  int num_wanted() const noexcept override { return 1; }
  int num_workers() override { return 1; }
  void run(int num_tasks, const Task& task) override {
    std::vector<int> order(static_cast<std::size_t>(num_tasks));
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), random_);
    for (const int i : order) task(i, 0);
  }

 private:
  std::mt19937 random_{20061};
};

}  // namespace

std::unique_ptr<Runner> make_runner(int num_threads) {
  if (num_threads <= 0)
    num_threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return std::make_unique<ThreadRunner>(num_threads);
}

std::unique_ptr<Runner> make_shuffled_runner() { return std::make_unique<ShuffleRunner>(); }

}  // namespace ovoid::cpu
