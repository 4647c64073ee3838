// SPDX-License-Identifier: Apache-2.0
// Whether files are there, asked beside the interface: a disk behind a network that does not answer
// keeps whoever asks for minutes.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace ovoid::viewer {

class FileFinder {
 public:
  // About one path, from any thread, for as long as it takes.
  using Question = std::function<bool(const std::string& path)>;
  explicit FileFinder(Question is_there);

  using Paths = std::vector<std::string>;
  // Asks whether all of them are there, in a thread of their own, which nobody waits for: not this
  // call, and not the end of the program. Nothing is asked twice at a time.
  void look_for(const Paths& paths);
  // The newest answer; none: there has been none yet.
  std::optional<bool> are_there(const Paths& paths) const;
  // Whether there has been an answer since the last call.
  bool take_news();

 private:
  struct State;
  std::shared_ptr<State> state_;  // the threads', too
};

}  // namespace ovoid::viewer
