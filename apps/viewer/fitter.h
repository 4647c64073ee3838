// SPDX-License-Identifier: Apache-2.0
// Fewer kernels for what is shown, by the words of `ovoid fit`, on a thread of its own that gives
// way to the pictures.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "loader.h"
#include "make_fit.h"

namespace ovoid::viewer {

struct FitTask {
  std::shared_ptr<const Shown> of;
  cli::Words words;       // of the command, behind "ovoid fit"; the name of its output is a fit's
  cli::ModelFlags model;  // that `of` is drawn with
  RendererSetup setup;
};

// A fit that was made. Immutable.
struct Fitted {
  // What it is of.
  ArrayChoice choice;
  double time = 0;
  // As the command tells it.
  FitReport report;
  cli::ReportRows rows;
  std::vector<std::string> notes;
  cli::Words words;
  std::string bytes;  // of the file
  // As the file is drawn.
  std::shared_ptr<const Shown> shown;
  std::shared_ptr<const Shown> within;  // the surface of what it is of; null: that has none
  std::shared_ptr<const Extras> extras;

  bool is_of(const Shown& other) const {
    return !other.solid && choice == choice_of(other) && time == other.time;
  }
};

struct FitProgress {
  bool is_running = false;
  double fraction = 0;
};

// What became of a task.
struct FitOutcome {
  std::shared_ptr<const Fitted> fitted;
  std::string error;  // why there is none, one line
};

// All members may be called from one thread, the interface's.
class Fitter {
 public:
  Fitter();
  ~Fitter();  // stops, and waits until it has
  Fitter(const Fitter&) = delete;
  Fitter& operator=(const Fitter&) = delete;

  void start(FitTask task);  // ends the one before
  void cancel();             // nothing comes of it
  void stop();               // cancels for good, and does not wait

  FitProgress progress() const;
  std::optional<FitOutcome> take();  // of the task that ended since the last call

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovoid::viewer
