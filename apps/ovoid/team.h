// SPDX-License-Identifier: Apache-2.0
// Processes that draw one picture together. Each runs the same command; what is declared here all
// of them do, at the same places and in the same order.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "ovoid/deep_image.h"
#include "ovoid/devices.h"
#include "ovoid/image.h"
#include "ovoid/kernel_team.h"
#include "ovoid/look.h"

namespace ovoid::cli {

// What went wrong for one of them, thrown in all. The first process tells it.
class TeamError : public std::runtime_error {
 public:
  TeamError(const std::string& message, int exit_code)
      : std::runtime_error(message), exit_code_(exit_code) {}
  int exit_code() const noexcept { return exit_code_; }

 private:
  int exit_code_;
};

// Which of a machine's graphics processors the process at `place` among those of a team takes, by
// DeviceInfo::index: one after the other; -1, the usual one, where there are not several.
int device_at_place(const DeviceList& list, int place);

class Team {
 public:
  virtual ~Team() = default;

  virtual int number() const = 0;  // of this process, from 0
  virtual int count() const = 0;
  virtual int beside() const = 0;   // processes of the team on this machine, this among them
  virtual int place() const = 0;    // of this process among these, from 0
  virtual int threads() const = 0;  // that this process may take of its machine's

  // Waits for all, and long, as one may draw more than another. Throws TeamError in all if
  // something went wrong for one (its line and exit code, which is not 0); ends the job if somebody
  // never comes.
  virtual void meet(const std::string& problem = {}, int exit_code = 0) = 0;
  // Throws TeamError in all, naming the first line that differs, unless all have the same lines.
  // Whoever has read and modelled the data waits less long for the others.
  virtual void agree(const std::string& lines) = 0;

  struct Spread {
    double least, greatest;
  };
  virtual Spread spread(double value) = 0;

  struct Picture {
    Image image;
    double exchange_ms = 0, composite_ms = 0;
    std::int64_t bytes = 0;  // of kernels, runs and pixels, sent from one process to another
  };
  // Through which the library shares kernels; null: each process has all.
  virtual std::shared_ptr<KernelTeam> kernels() = 0;

  // Of what all have seen, at the first process; elsewhere none.
  virtual std::optional<Picture> put_together(const DeepImage& seen, const Look& look) = 0;
};

}  // namespace ovoid::cli
