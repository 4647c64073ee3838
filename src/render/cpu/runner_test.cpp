// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/runner.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <vector>

#include "ovoid/error.h"

namespace ovoid::cpu {
namespace runner_test {

enum class Kind { kThreads, kShuffled };

class EveryRunner : public ::testing::TestWithParam<Kind> {
 protected:
  std::unique_ptr<Runner> make(int threads) const {
    return GetParam() == Kind::kThreads ? make_runner(threads) : make_shuffled_runner();
  }
};

// Fails if a task is left out or done twice, or a worker's number is out of range.
TEST_P(EveryRunner, DoesEachTaskOnce) {
  for (const int threads : {1, 2, 5}) {
    const auto runner = make(threads);
    for (const int num_tasks : {0, 1, 3, 500}) {
      std::vector<std::atomic<int>> times(static_cast<std::size_t>(num_tasks));
      runner->run(num_tasks, [&](int task, int worker) {
        ++times[static_cast<std::size_t>(task)];
        EXPECT_GE(worker, 0);
        EXPECT_LT(worker, runner->num_workers());
      });
      for (const auto& n : times) ASSERT_EQ(n, 1);
    }
  }
}

// Fails if two tasks run with one worker's number at a time: its memory would be written by both.
TEST_P(EveryRunner, NoWorkerIsTwoAtATime) {
  const auto runner = make(4);
  std::array<std::atomic<int>, 4> busy{};
  runner->run(400, [&](int, int worker) {
    auto& mine = busy[static_cast<std::size_t>(worker)];
    EXPECT_EQ(mine++, 0);
    std::atomic<int> work{0};
    while (work < 2000) ++work;
    --mine;
  });
}

// Fails if an exception is lost or changed, or all tasks are still done after it.
TEST_P(EveryRunner, RethrowsAndStops) {
  const auto runner = make(3);
  std::atomic<int> done{0};
  try {
    runner->run(100000, [&](int, int) {
      const int number = ++done;
      if (number == 10) throw Error(ErrorCode::kFileFormat, "the tenth");
      // Time for the tenth to say so, whoever else has the processor.
      if (number > 10) std::this_thread::sleep_for(std::chrono::microseconds(20));
    });
    FAIL() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "the tenth");
    EXPECT_EQ(error.code(), ErrorCode::kFileFormat);
  }
  EXPECT_LT(done, 100000);
  int after = 0;
  runner->run(1, [&](int, int) { ++after; });
  EXPECT_EQ(after, 1);
}

INSTANTIATE_TEST_SUITE_P(Kinds, EveryRunner, ::testing::Values(Kind::kThreads, Kind::kShuffled));

// Fails if tasks come in order, which would hide that they depend on it.
TEST(Runner, ShuffleScrambles) {
  std::vector<int> order;
  make_shuffled_runner()->run(100, [&](int task, int) { order.push_back(task); });
  EXPECT_FALSE(std::is_sorted(order.begin(), order.end()));
}

// Fails if a run takes tasks of another, or two that come at a time mix them up.
TEST(Runner, ThreadsTakeOneRunAfterTheOther) {
  const auto runner = make_runner(3);
  std::array<std::atomic<int>, 2> done{};
  {
    std::vector<std::jthread> callers;
    for (std::size_t caller = 0; caller < 2; ++caller) {
      callers.emplace_back([&, caller] {
        for (int i = 0; i < 200; ++i) runner->run(7, [&](int, int) { ++done[caller]; });
      });
    }
  }
  EXPECT_EQ(done[0], 1400);
  EXPECT_EQ(done[1], 1400);
}

TEST(Runner, ZeroThreadsIsOnePerHardwareThread) { EXPECT_GE(make_runner(0)->num_workers(), 1); }

}  // namespace runner_test
}  // namespace ovoid::cpu
