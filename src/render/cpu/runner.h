// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>

namespace ovoid::cpu {

// Runs independent tasks on worker threads. Which worker takes which task, and in what order, must
// not matter to the result.
class Runner {
 public:
  // `worker` in [0, num_workers()): no two tasks run with the same worker at a time, so it names
  // memory that a task may use alone.
  using Task = std::function<void(int task, int worker)>;

  virtual ~Runner() = default;
  // As many as there are: fewer than num_wanted() where the system grants no more threads. The same
  // from the first call on.
  virtual int num_workers() = 0;
  virtual int num_wanted() const noexcept = 0;
  // Returns when all tasks in [0, num_tasks) are done. An exception of a task is rethrown here, one
  // of them if several; no new task starts after it.
  virtual void run(int num_tasks, const Task& task) = 0;
};

// Threads of its own; 0: one per hardware thread.
std::unique_ptr<Runner> make_runner(int num_threads);

// The tasks one after the other on the calling thread in a scrambled order: for tests of
// independence.
std::unique_ptr<Runner> make_shuffled_runner();

}  // namespace ovoid::cpu
