// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "console.h"
#include "interrupt.h"
#include "ovoid/dataset.h"

namespace ovoid::cli {

class Team;

// Milliseconds since it was made.
class Stopwatch {
 public:
  double ms() const {
    return std::chrono::duration<double, std::milli>(Clock::now() - start_).count();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

// One line on a terminal that tells how far long work has come: "drawing [####......]  42 %".
// Appears after half a second, and is gone when the object is; nothing is written where standard
// error is no terminal.
class Progress {
 public:
  explicit Progress(std::string what);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // From now on no line is shown: of programs that are not ours.
  static void be_silent() noexcept;

  // `fraction` in [0, 1]; one thread at a time.
  void show(double fraction);
  // From now on.
  void rename(std::string what);
  std::function<void(double)> callback() {
    return [this](double fraction) { show(fraction); };
  }

 private:
  std::string what_;
  bool is_terminal_;
  int shown_percent_ = -1;
  std::size_t shown_size_ = 0;
  Stopwatch since_;
};

// What lasts for one run of the program: Ctrl-C and what is told to the person.
class Session {
 public:
  using Tell = std::function<void(const std::string& note)>;

  // So long may work that was asked to stop take to do so. With the program's own end that is
  // within 0.2 s.
  static constexpr std::chrono::milliseconds kGrace{120};

  explicit Session(const std::vector<std::string>& words, std::chrono::milliseconds grace = kGrace);
  // One of several pieces of work in a program that goes on: notes go to `tell`, and `stop` stops
  // it, not Ctrl-C.
  Session(Tell tell, std::stop_token stop);

  // A line on standard error, each text once.
  void note(const std::string& text);
  void notes(const std::vector<std::string>& texts);
  std::stop_token stop() const { return stop_; }
  // Throws Error(kCancelled) if Ctrl-C was pressed; for work that does not look itself.
  void check_stop() const;

  const std::string& command_line() const noexcept { return command_line_; }

  // Data in memory that stand for files of these names; those that were provided before are none.
  using Provided = std::map<std::string, std::shared_ptr<const Dataset>>;
  void provide(Provided data) { provided_ = std::move(data); }
  // Null: a name means a file.
  std::shared_ptr<const Dataset> provided(const std::string& name) const;

  // One of several processes that draw a picture together; null: alone.
  void join(Team& team) noexcept;
  Team* team() const noexcept { return team_; }

 private:
  std::string command_line_;
  std::vector<std::string> told_;
  int num_quiet_ = 0;
  std::optional<Interrupt> interrupt_;
  Tell tell_;
  std::stop_token stop_;
  Team* team_ = nullptr;
  Provided provided_;

  friend class Quiet;
};

// While it lives notes are neither told nor remembered: those on steps that are read one after the
// other would be as many.
class Quiet {
 public:
  explicit Quiet(Session& session) : session_(session) { ++session_.num_quiet_; }
  ~Quiet() { --session_.num_quiet_; }
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

 private:
  Session& session_;
};

// The words as a shell would take them again, in one line.
std::string quoted(const std::vector<std::string>& words);

bool has_ending(const std::string& path, const std::string& ending);  // "x.PNG" has ".png"

}  // namespace ovoid::cli
