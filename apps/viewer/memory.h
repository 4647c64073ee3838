// SPDX-License-Identifier: Apache-2.0
// What the window remembers from one run to the next, in a file of JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "flag_set.h"
#include "settings.h"
#include "theme.h"

namespace ovoid::viewer {

// ovoid/window.json in $XDG_STATE_HOME, or else in ~/.local/state; empty where there is neither.
std::string usual_memory_path();

// What was opened, and can be again.
struct RecentInput {
  std::vector<std::string> inputs;  // absolute paths
  cli::FlagSet flags;               // that say how they are read
  bool is_there = true;             // all of them, when the list was made

  std::string title() const;   // "step_1.vti and 3 more"
  std::string folder() const;  // of the first, "~" for the home
  cli::Words words() const;    // as on the command line
};

RecentInput recent_input(const cli::DataFlags& data);

// A file that is not there, cannot be read or makes no sense is as good as an empty one, as is each
// part of it. It is read again before it is changed, so that two windows do not take each other's
// word, and is written whole.
class Memory {
 public:
  explicit Memory(std::string path);  // empty: remembers nothing beyond this run

  Theme theme() const noexcept { return theme_; }
  // The last one first, kMostRecent at most, each once.
  const std::vector<RecentInput>& recent() const noexcept { return recent_; }
  static constexpr std::size_t kMostRecent = 10;

  // Throw Error(kFileWrite); what they were told is known all the same.
  void set_theme(Theme theme);
  void add_recent(RecentInput input);
  void forget_recent();

 private:
  void read();
  void write();

  std::string path_;
  nlohmann::ordered_json kept_ = nlohmann::ordered_json::object();  // others' members, too
  Theme theme_ = Theme::kDark;
  std::vector<RecentInput> recent_;
};

}  // namespace ovoid::viewer
