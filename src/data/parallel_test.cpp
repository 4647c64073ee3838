// SPDX-License-Identifier: Apache-2.0
#include "data/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

#include "ovoid/error.h"

namespace ovoid::data {
namespace parallel_test {

// Fails if an item is left out, done twice, or a range is longer than the grain.
TEST(ParallelRanges, CoverEveryItemOnce) {
  for (const std::int64_t count : {0, 1, 7, 64, 1000}) {
    for (const std::int64_t grain : {1, 3, 64, 5000}) {
      for (const int threads : {1, 2, 9}) {
        std::vector<std::atomic<int>> visits(static_cast<std::size_t>(count));
        std::atomic<bool> is_too_long = false;
        parallel_ranges({count, grain, threads, {}}, [&](std::int64_t begin, std::int64_t end) {
          if (end - begin > grain) is_too_long = true;
          for (std::int64_t i = begin; i < end; ++i) ++visits[i];
        });
        for (const auto& visit : visits) ASSERT_EQ(visit, 1);
        EXPECT_FALSE(is_too_long);
      }
    }
  }
}

// Fails if the exception ends the program, is lost, or the rest of the work is still done.
TEST(ParallelRanges, RethrowTheFirstFailure) {
  std::atomic<int> done = 0;
  const auto fail_at_ten = [&](std::int64_t begin, std::int64_t) {
    if (begin == 10) throw std::runtime_error("ten");
    ++done;
  };
  EXPECT_THROW(parallel_ranges({1'000'000, 1, 1, {}}, fail_at_ten), std::runtime_error);
  EXPECT_EQ(done, 10);
  EXPECT_THROW(parallel_ranges({1'000'000, 1, 4, {}}, fail_at_ten), std::runtime_error);
}

TEST(ParallelRanges, StopBetweenRanges) {
  std::stop_source source;
  int done = 0;
  try {
    parallel_ranges({100, 1, 1, source.get_token()}, [&](std::int64_t, std::int64_t) {
      if (++done == 5) source.request_stop();
    });
    FAIL() << "not cancelled";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kCancelled);
  }
  EXPECT_EQ(done, 5);
}

// What is half done may not be taken for done: bodies end early when they see the token.
TEST(ParallelRanges, AStopInTheLastRangeIsTold) {
  std::stop_source source;
  EXPECT_THROW(parallel_ranges({5, 1, 1, source.get_token()},
                               [&](std::int64_t begin, std::int64_t) {
                                 if (begin == 4) source.request_stop();
                               }),
               Error);
}

TEST(ResolveThreads, TakesZeroAsAllAndRefusesNonsense) {
  EXPECT_GE(resolve_threads(0), 1);
  EXPECT_EQ(resolve_threads(3), 3);
  EXPECT_THROW(resolve_threads(-1), Error);
  EXPECT_THROW(resolve_threads(kMaxThreads + 1), Error);
}

}  // namespace parallel_test
}  // namespace ovoid::data
