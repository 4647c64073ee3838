// SPDX-License-Identifier: Apache-2.0
// What the window remembers from one run to the next, in a file of JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "file_finder.h"
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
  bool is_there = true;             // all of them, as far as is known

  std::string title() const;   // "step_1.vti and 3 more"
  std::string folder() const;  // of the first, "~" for the home
  cli::Words words() const;    // as on the command line
};

RecentInput recent_input(const cli::DataFlags& data);

// Of FileFinder, with the file system.
bool is_file_there(const std::string& path);

// A file that is not there, cannot be read or makes no sense is as good as an empty one, as is each
// part of it. It is read again before it is changed, so that two windows do not take each other's
// word, and is written whole.
class Memory {
 public:
  // An empty path: remembers nothing beyond this run.
  explicit Memory(std::string path, FileFinder::Question is_there = is_file_there);

  Theme theme() const noexcept { return theme_; }
  // The last one first, kMostRecent at most, each once.
  const std::vector<RecentInput>& recent() const noexcept { return recent_; }
  static constexpr std::size_t kMostRecent = 10;
  // Takes in which of them are there, which is asked whenever the file is read; whether that has
  // changed the list. Does not wait.
  bool update();

  // Throw Error(kFileWrite); what they were told is known all the same.
  void set_theme(Theme theme);
  void add_recent(RecentInput input);
  void forget_recent();

 private:
  void read();
  void write();
  void mark_those_there();

  std::string path_;
  nlohmann::ordered_json kept_ = nlohmann::ordered_json::object();  // others' members, too
  Theme theme_ = Theme::kDark;
  std::vector<RecentInput> recent_;
  FileFinder finder_;
};

}  // namespace ovoid::viewer
