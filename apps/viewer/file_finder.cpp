// SPDX-License-Identifier: Apache-2.0
#include "file_finder.h"

#include <algorithm>
#include <exception>
#include <map>
#include <mutex>
#include <set>
#include <system_error>
#include <thread>
#include <utility>

namespace ovoid::viewer {

struct FileFinder::State {
  Question is_there;
  std::mutex mutex;  // of what follows
  std::set<Paths> asked;
  std::map<Paths, bool> answers;
  bool has_news = false;
};

FileFinder::FileFinder(Question is_there) : state_(std::make_shared<State>()) {
  state_->is_there = std::move(is_there);
}

void FileFinder::look_for(const Paths& paths) {
  const std::lock_guard lock(state_->mutex);
  if (!state_->asked.insert(paths).second) return;
  try {
    std::thread([state = state_, paths] {
      bool are_there = false;
      try {
        are_there = std::all_of(paths.begin(), paths.end(), state->is_there);
      } catch (const std::exception&) {  // as good as not there
      }
      const std::lock_guard writing(state->mutex);
      state->asked.erase(paths);
      state->answers[paths] = are_there;
      state->has_news = true;
    }).detach();
  } catch (const std::system_error&) {  // no thread to be had: not known
    state_->asked.erase(paths);
  }
}

std::optional<bool> FileFinder::are_there(const Paths& paths) const {
  const std::lock_guard lock(state_->mutex);
  const auto found = state_->answers.find(paths);
  if (found == state_->answers.end()) return std::nullopt;
  return found->second;
}

bool FileFinder::take_news() {
  const std::lock_guard lock(state_->mutex);
  return std::exchange(state_->has_news, false);
}

}  // namespace ovoid::viewer
