// SPDX-License-Identifier: Apache-2.0
// What the window remembers from one run to the next, in a file of JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "theme.h"

namespace ovoid::viewer {

// ovoid/window.json in $XDG_STATE_HOME, or else in ~/.local/state; empty where there is neither.
std::string usual_memory_path();

// A file that is not there, cannot be read or makes no sense is as good as an empty one, as is each
// part of it. It is read again before it is changed, so that two windows do not take each other's
// word, and is written whole.
class Memory {
 public:
  explicit Memory(std::string path);  // empty: remembers nothing beyond this run

  Theme theme() const noexcept { return theme_; }
  void set_theme(Theme theme);  // throws Error(kFileWrite); it is known all the same

 private:
  void read();
  void write();

  std::string path_;
  nlohmann::ordered_json kept_ = nlohmann::ordered_json::object();  // others' members, too
  Theme theme_ = Theme::kDark;
};

}  // namespace ovoid::viewer
