// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mpi.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "ovoid/kernel_team.h"

namespace ovoid::cli {

// The processes of a team, as the library sees them where they share kernels. A thread answers what
// the others ask, for as long as this lives: until all have met for the last time. MPI may be
// called by several threads at once.
class MpiKernelTeam final : public KernelTeam {
 public:
  using Duration = std::chrono::duration<double>;
  // `meet`: waits for the others, and throws in all if one has failed. `patience`: how long an
  // answer is waited for.
  MpiKernelTeam(int number, int count, std::function<void()> meet, Duration patience);
  ~MpiKernelTeam() override;
  MpiKernelTeam(const MpiKernelTeam&) = delete;
  MpiKernelTeam& operator=(const MpiKernelTeam&) = delete;

  int number() const noexcept override { return number_; }
  int count() const noexcept override { return count_; }
  Letters exchange(Letters letters) override;
  int answer(Answer answer) override;
  std::vector<std::byte> fetch(int process, int question, std::int64_t number) const override;

  std::int64_t bytes_sent() const noexcept { return bytes_sent_; }

 private:
  Letters exchange_here(Letters letters);
  void answer_all();
  bool answer_one();
  std::vector<std::byte> answer_to(int question, std::int64_t number);

  int number_, count_;
  std::function<void()> meet_;
  Duration patience_;
  MPI_Comm letters_ = MPI_COMM_NULL, questions_ = MPI_COMM_NULL;
  mutable std::atomic<unsigned> next_reply_ = 0;
  std::atomic<std::int64_t> bytes_sent_ = 0;
  std::mutex mutex_;  // of the answers
  std::vector<Answer> answers_;
  std::atomic<bool> is_over_ = false;
  std::thread answering_;
};

}  // namespace ovoid::cli
