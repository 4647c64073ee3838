// SPDX-License-Identifier: Apache-2.0
// Steps are made in memory and counted. Fails if more are held than the limit allows, if a step is
// read twice at a time, if the wrong one goes, or if an error, a stop or a prefetch is lost.
#include "ovoid/series.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <limits>
#include <mutex>
#include <numeric>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include "ovoid/error.h"

namespace ovoid {
namespace series_test {

constexpr std::size_t kStepBytes = 1000;

// Steps of 10 x 10 x 10 bytes that hold their number.
class CountedSteps final : public StepSource {
 public:
  explicit CountedSteps(std::int64_t count) : times_(static_cast<std::size_t>(count)) {
    std::iota(times_.begin(), times_.end(), 0.0);
  }

  const std::string& name() const noexcept override { return name_; }
  std::int64_t num_steps() const noexcept override {
    return static_cast<std::int64_t>(times_.size());
  }
  const std::vector<double>& times() const noexcept override { return times_; }
  bool has_times() const noexcept override { return false; }

  Dataset read(std::int64_t step, std::stop_token stop) const override {
    {
      std::unique_lock lock(mutex_);
      ++num_reads_;
      reads_.push_back(step);
      EXPECT_TRUE(running_.insert(step).second) << "step " << step << " is read twice at a time";
      changed_.notify_all();
      changed_.wait(lock, stop, [&] { return !held_back_.contains(step); });
      running_.erase(step);
      changed_.notify_all();
    }
    if (stop.stop_requested()) throw Error(ErrorCode::kCancelled, "stopped");
    if (broken_ == step) throw Error(ErrorCode::kFileFormat, "step is broken");
    most_alive_ = std::max<int>(most_alive_, ++num_alive_);
    const std::shared_ptr<std::vector<std::byte>> bytes(
        new std::vector<std::byte>(kStepBytes, std::byte(step % 256)),
        [this](std::vector<std::byte>* dead) {
          delete dead;  // NOLINT(cppcoreguidelines-owning-memory)
          --num_alive_;
        });
    Dataset dataset;
    dataset.source = "memory";
    dataset.lattice.dims = {10, 10, step == odd_sized_ ? 5 : 10};
    dataset.arrays.push_back({"values", ScalarType::kUInt8, 1, 1000, "", false, {bytes, *bytes}});
    return dataset;
  }

  void hold_back(std::set<std::int64_t> steps) {
    const std::lock_guard lock(mutex_);
    held_back_ = std::move(steps);
    changed_.notify_all();
  }
  // Until `step` has been read so often, at most ten seconds.
  bool wait_for_reads(std::int64_t step, std::ptrdiff_t count = 1) const {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::seconds(10), [&] {
      return std::count(reads_.begin(), reads_.end(), step) >= count && !running_.contains(step);
    });
  }
  bool wait_for_begin(std::int64_t step) const {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::seconds(10),
                             [&] { return running_.contains(step); });
  }
  std::vector<std::int64_t> reads() const {
    const std::lock_guard lock(mutex_);
    return reads_;
  }

  mutable std::atomic<int> num_reads_{0}, num_alive_{0}, most_alive_{0};
  std::atomic<std::int64_t> broken_{-1}, odd_sized_{-1};

 private:
  std::string name_ = "counted";
  std::vector<double> times_;
  mutable std::mutex mutex_;
  mutable std::condition_variable_any changed_;
  mutable std::vector<std::int64_t> reads_;
  mutable std::set<std::int64_t> running_;
  std::set<std::int64_t> held_back_;
};

using Steps = std::vector<std::int64_t>;

int value_of(const Dataset& dataset) {
  return std::to_integer<int>(dataset.arrays.at(0).bytes.view.front());
}

TEST(Series, NeverHoldsMoreThanItsLimit) {
  const auto source = std::make_shared<CountedSteps>(100);
  for (const bool prefetch : {false, true}) {
    const Series series(source, {.memory_limit = 4 * kStepBytes, .prefetch = prefetch});
    for (int loop = 0; loop < 1000; ++loop) {
      for (std::int64_t step = 0; step < (loop < 3 ? 100 : 5); ++step) {
        EXPECT_EQ(value_of(*series.step(step)), step);
        EXPECT_LE(series.resident_bytes(), 4 * kStepBytes);
      }
    }
    EXPECT_LE(source->most_alive_, 4);
  }
  EXPECT_EQ(source->num_alive_, 0);
}

TEST(Series, TheOneUsedLongestAgoGoes) {
  const auto source = std::make_shared<CountedSteps>(10);
  const Series series(source, {.memory_limit = 3 * kStepBytes, .prefetch = false});
  for (const std::int64_t step : {0, 1, 2, 0, 3, 0, 2, 1}) series.step(step);
  EXPECT_EQ(source->reads(), (Steps{0, 1, 2, 3, 1}));
  EXPECT_EQ(series.num_resident(), 3);
}

TEST(Series, StepsInUseAreHeldAndFoundAgain) {
  const auto source = std::make_shared<CountedSteps>(10);
  const Series series(source, {.memory_limit = 2 * kStepBytes, .prefetch = false});
  std::vector<std::shared_ptr<const Dataset>> used;
  for (std::int64_t step = 0; step < 5; ++step) used.push_back(series.step(step));
  EXPECT_EQ(source->num_alive_, 5);
  EXPECT_LE(series.resident_bytes(), 2 * kStepBytes);
  EXPECT_EQ(series.step(0), used[0]) << "read again though it was there";
  EXPECT_EQ(source->num_reads_, 5);
  used.clear();
  EXPECT_LE(source->num_alive_, 2) << "kept beyond the limit when it was let go of";
  EXPECT_EQ(static_cast<std::size_t>(source->num_alive_) * kStepBytes, series.resident_bytes());
}

TEST(Series, ALimitBelowOneStepStillGivesIt) {
  const auto source = std::make_shared<CountedSteps>(3);
  const Series series(source, {.memory_limit = 1});
  for (const std::int64_t step : {0, 1, 2}) EXPECT_EQ(value_of(*series.step(step)), step);
  EXPECT_EQ(source->num_alive_, 0);
}

TEST(Series, ManyThreadsReadAStepOnce) {
  const auto source = std::make_shared<CountedSteps>(4);
  const Series series(source, {.prefetch = false});
  source->hold_back({2});
  std::atomic<int> num_right{0};
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 8; ++i)
      threads.emplace_back([&] { num_right += value_of(*series.step(2)) == 2 ? 1 : 0; });
    EXPECT_TRUE(source->wait_for_begin(2));
    source->hold_back({});
  }
  EXPECT_EQ(num_right, 8);
  EXPECT_EQ(source->num_reads_, 1);
}

TEST(Series, ManyThreadsAtManySteps) {
  const auto source = std::make_shared<CountedSteps>(50);
  constexpr int kThreads = 4;
  {
    const Series series(source, {.memory_limit = 8 * kStepBytes});
    std::vector<std::jthread> threads;
    for (int i = 0; i < kThreads; ++i) {
      threads.emplace_back([&, i] {
        for (std::int64_t n = 0; n < 300; ++n) {
          const std::int64_t step = i % 2 == 0 ? (n + 5 * i) % 50 : (7 * n) % 50;
          EXPECT_EQ(value_of(*series.step(step)), step);
        }
      });
    }
    threads.clear();
    EXPECT_LE(series.resident_bytes(), 8 * kStepBytes);
  }
  EXPECT_EQ(source->num_alive_, 0);
}

TEST(Series, TheNextStepIsReadAhead) {
  const auto source = std::make_shared<CountedSteps>(100);
  const Series series(source, {.memory_limit = 4 * kStepBytes});
  series.step(10);
  EXPECT_TRUE(source->wait_for_reads(11));
  series.step(11);
  EXPECT_TRUE(source->wait_for_reads(12));
  EXPECT_EQ(source->num_reads_, 3) << "11 was read twice";
  // Backwards, and then in leaps.
  series.step(50);
  EXPECT_TRUE(source->wait_for_reads(51));
  series.step(49);
  EXPECT_TRUE(source->wait_for_reads(48));
  series.step(44);
  series.step(39);
  EXPECT_TRUE(source->wait_for_reads(34));
}

TEST(Series, NothingIsReadAheadWhereThereIsNoRoom) {
  const auto source = std::make_shared<CountedSteps>(100);
  const Series series(source, {.memory_limit = 2 * kStepBytes});
  const auto a = series.step(20);
  EXPECT_TRUE(source->wait_for_reads(21));
  const auto b = series.step(21);
  const auto c = series.step(22);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_EQ(source->reads(), (Steps{20, 21, 22}));
}

TEST(Series, WhatIsNoLongerLikelyIsNotReadToTheEnd) {
  const auto source = std::make_shared<CountedSteps>(100);
  const Series series(source, {.memory_limit = 10 * kStepBytes});
  source->hold_back({11});
  series.step(10);
  EXPECT_TRUE(source->wait_for_begin(11));
  series.step(60);
  EXPECT_TRUE(source->wait_for_reads(61)) << "the reader hangs on step 11";
  EXPECT_EQ(value_of(*series.step(60)), 60);
}

TEST(Series, DestructionEndsWhatIsReadAhead) {
  const auto source = std::make_shared<CountedSteps>(100);
  {
    const Series series(source);
    source->hold_back({1});
    series.step(0);
    EXPECT_TRUE(source->wait_for_begin(1));
  }
  EXPECT_EQ(source->num_alive_, 0);
}

TEST(Series, AFailureAheadIsToldWhenTheStepIsAskedFor) {
  const auto source = std::make_shared<CountedSteps>(5);
  source->broken_ = 1;
  const Series series(source);
  series.step(0);
  EXPECT_TRUE(source->wait_for_reads(1));
  for (int i = 0; i < 2; ++i) {
    try {
      series.step(1);
      FAIL() << "nothing was thrown";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kFileFormat);
      EXPECT_STREQ(error.what(), "step is broken");
    }
  }
  source->broken_ = -1;
  EXPECT_EQ(value_of(*series.step(1)), 1);
}

TEST(Series, AStopEndsReadingAndWaiting) {
  const auto source = std::make_shared<CountedSteps>(5);
  const Series series(source, {.prefetch = false});
  source->hold_back({3});
  std::stop_source reading, waiting;
  const auto code_of = [&](const std::stop_source& stop) {
    try {
      series.step(3, stop.get_token());
      return ErrorCode::kInvalidArgument;
    } catch (const Error& error) {
      return error.code();
    }
  };
  ErrorCode first{}, second{};
  std::jthread reader([&] { first = code_of(reading); });
  EXPECT_TRUE(source->wait_for_begin(3));
  std::jthread waiter([&] { second = code_of(waiting); });
  waiting.request_stop();
  waiter.join();
  EXPECT_EQ(second, ErrorCode::kCancelled);
  // Who waits for one that is stopped reads itself.
  std::shared_ptr<const Dataset> data;
  std::jthread heir([&] { data = series.step(3); });
  reading.request_stop();
  reader.join();
  EXPECT_EQ(first, ErrorCode::kCancelled);
  source->hold_back({});
  heir.join();
  ASSERT_NE(data, nullptr);
  EXPECT_EQ(value_of(*data), 3);
}

TEST(Series, StepsThatDifferAreAnError) {
  const auto source = std::make_shared<CountedSteps>(5);
  source->odd_sized_ = 2;
  const Series series(source, {.prefetch = false});
  series.step(0);
  try {
    series.step(2);
    FAIL() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kFileFormat);
    EXPECT_STREQ(error.what(),
                 "memory: step 2: has 10 x 10 x 5 samples, step 0 has 10 x 10 x 10: the steps of a "
                 "series are alike");
  }
  EXPECT_EQ(value_of(*series.step(1)), 1);
  EXPECT_THROW(series.step(5), Error);
  EXPECT_THROW(series.step(-1), Error);
}

TEST(Series, KnowsTheNearestStep) {
  const Series series(std::make_shared<CountedSteps>(5));
  EXPECT_EQ(series.nearest_step(-7), 0);
  EXPECT_EQ(series.nearest_step(1.5), 1);
  EXPECT_EQ(series.nearest_step(1.6), 2);
  EXPECT_EQ(series.nearest_step(99), 4);
}

class BadTimes final : public StepSource {
 public:
  explicit BadTimes(std::vector<double> times) : times_(std::move(times)) {}
  const std::string& name() const noexcept override { return name_; }
  std::int64_t num_steps() const noexcept override { return 2; }
  const std::vector<double>& times() const noexcept override { return times_; }
  bool has_times() const noexcept override { return true; }
  Dataset read(std::int64_t, std::stop_token) const override { return {}; }

 private:
  std::string name_ = "bad";
  std::vector<double> times_;
};

TEST(Series, RefusesSourcesWithoutTimesThatRise) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const auto& times : std::vector<std::vector<double>>{{}, {0}, {1, 1}, {1, 0}, {0, kNan}})
    EXPECT_THROW(Series(std::make_shared<BadTimes>(times)), Error);
  EXPECT_THROW(Series(nullptr), Error);
}

}  // namespace series_test
}  // namespace ovoid
