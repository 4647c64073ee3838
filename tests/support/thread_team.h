// SPDX-License-Identifier: Apache-2.0
// Threads of one process as a team, for tests of what processes do together.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "ovoid/kernel_team.h"

namespace ovoid::testing {

// Where the threads of a team meet.
class Room {
 public:
  explicit Room(int count) : count_(count), letters_(static_cast<std::size_t>(count)) {}

  int count() const { return count_; }

  KernelTeam::Letters exchange(int number, KernelTeam::Letters letters) {
    letters_[static_cast<std::size_t>(number)] = std::move(letters);
    meet();
    KernelTeam::Letters received;
    for (const KernelTeam::Letters& from : letters_)
      received.push_back(from.at(static_cast<std::size_t>(number)));
    meet();
    return received;
  }

  void leave_in_failure() {
    const std::scoped_lock lock(mutex_);
    has_failed_ = true;
    changed_.notify_all();
  }

  // Of all answers that were fetched.
  std::int64_t num_fetched_bytes() const { return num_fetched_bytes_; }
  void add_fetched_bytes(std::size_t count) {
    num_fetched_bytes_ += static_cast<std::int64_t>(count);
  }

  // The answers of all, by process.
  std::vector<std::vector<KernelTeam::Answer>>& answers() { return answers_; }

 private:
  void meet() {
    std::unique_lock lock(mutex_);
    const int round = round_;
    if (++present_ == count_) {
      present_ = 0;
      ++round_;
      changed_.notify_all();
    }
    changed_.wait(lock, [&] { return round != round_ || has_failed_; });
    if (round == round_) throw std::runtime_error("another of the team has failed");
  }

  int count_;
  std::vector<KernelTeam::Letters> letters_;
  std::vector<std::vector<KernelTeam::Answer>> answers_{letters_.size()};
  std::mutex mutex_;
  std::condition_variable changed_;
  int present_ = 0, round_ = 0;
  bool has_failed_ = false;
  std::atomic<std::int64_t> num_fetched_bytes_ = 0;
};

class ThreadTeam final : public KernelTeam {
 public:
  ThreadTeam(Room& room, int number) : room_(room), number_(number) {}

  int number() const noexcept override { return number_; }
  int count() const noexcept override { return room_.count(); }
  Letters exchange(Letters letters) override { return room_.exchange(number_, std::move(letters)); }
  int answer(Answer answer) override {
    auto& own = room_.answers()[static_cast<std::size_t>(number_)];
    own.push_back(std::move(answer));
    room_.exchange(number_, Letters(static_cast<std::size_t>(count())));
    return static_cast<int>(own.size()) - 1;
  }
  std::vector<std::byte> fetch(int process, int question, std::int64_t number) const override {
    std::vector<std::byte> answer = room_.answers()
                                        .at(static_cast<std::size_t>(process))
                                        .at(static_cast<std::size_t>(question))(number);
    room_.add_fetched_bytes(answer.size());
    return answer;
  }

 private:
  Room& room_;
  int number_;
};

// Runs body(team) for each of `count` processes; what it returns, by process. Throws what the first
// that failed has thrown.
template <class Body>
auto run_as_team(Room& room, const Body& body) {
  using Result = std::invoke_result_t<Body, std::shared_ptr<KernelTeam>>;
  const auto count = static_cast<std::size_t>(room.count());
  std::vector<Result> results(count);
  std::exception_ptr failure;
  std::mutex mutex;
  std::vector<std::thread> threads;
  for (std::size_t p = 0; p < count; ++p) {
    threads.emplace_back([&, p] {
      try {
        results[p] = body(std::make_shared<ThreadTeam>(room, static_cast<int>(p)));
      } catch (...) {
        const std::scoped_lock lock(mutex);
        if (!failure) failure = std::current_exception();
        room.leave_in_failure();
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
  return results;
}

}  // namespace ovoid::testing
