// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "mpi_kernel_team.h"
#include "team.h"

namespace ovoid::cli {

// The processes of MPI_COMM_WORLD. MPI is there.
class MpiTeam final : public Team {
 public:
  using Duration = std::chrono::duration<double>;
  // `patience`: how long one waits for the others to have read the data, and a hundred times as
  // long for what they draw.
  // `has_threads`: several threads may call MPI at once.
  MpiTeam(Duration patience, bool has_threads);

  int number() const override { return number_; }
  int count() const override { return count_; }
  int beside() const override { return beside_; }
  int place() const override { return place_; }
  int threads() const override { return threads_; }

  void meet(const std::string& problem, int exit_code) override;
  void agree(const std::string& lines) override;
  Spread spread(double value) override;
  std::shared_ptr<KernelTeam> kernels() override { return kernels_; }
  std::optional<Picture> put_together(const DeepImage& seen, const Look& look) override;

 private:
  std::string text_of(int process, const std::string& own) const;
  void meet_within(Duration longest, const std::string& problem, int exit_code);
  Picture put_together_here(const DeepImage& seen, const Look& look);

  int number_ = 0, count_ = 1, beside_ = 1, place_ = 0, threads_ = 1;
  Duration patience_;
  std::shared_ptr<MpiKernelTeam> kernels_;
};

}  // namespace ovoid::cli
