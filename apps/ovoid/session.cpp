// SPDX-License-Identifier: Apache-2.0
#include "session.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cstring>
#include <utility>

#include "console.h"
#include "ovoid/error.h"
#include "team.h"

namespace ovoid::cli {
namespace {

constexpr int kNotThisPercent = 101;  // the line is shown again, whatever it says
constexpr double kQuietMs = 500;      // shorter work needs no progress line

std::atomic<bool> is_silent{false};

}  // namespace

Progress::Progress(std::string what)
    : what_(std::move(what)), is_terminal_(!is_silent && isatty(STDERR_FILENO) == 1) {}

void Progress::be_silent() noexcept { is_silent = true; }

Progress::~Progress() {
  if (shown_percent_ < 0) return;
  tell(fmt::format("\r{:{}}\r", "", shown_size_));
}

void Progress::show(double fraction) {
  const int percent = static_cast<int>(100.0 * std::clamp(fraction, 0.0, 1.0));
  if (!is_terminal_ || percent == shown_percent_ || since_.ms() < kQuietMs) return;
  shown_percent_ = percent;
  constexpr int kBar = 20;
  const std::string line =
      fmt::format("{} [{:.<{}}] {:3} %", what_,
                  std::string(static_cast<std::size_t>(percent * kBar / 100), '#'), kBar, percent);
  tell(fmt::format("\r{:{}}", line, shown_size_));
  shown_size_ = std::max(shown_size_, line.size());
}

void Progress::rename(std::string what) {
  what_ = std::move(what);
  if (shown_percent_ >= 0) shown_percent_ = kNotThisPercent;
}

Session::Session(const std::vector<std::string>& words, std::chrono::milliseconds grace)
    : command_line_(quoted(words)),
      interrupt_(std::in_place, grace),
      tell_([](const std::string& note) { tell(fmt::format("note: {}\n", note)); }),
      stop_(interrupt_->token()) {}

Session::Session(Tell tell, std::stop_token stop)
    : tell_(std::move(tell)), stop_(std::move(stop)) {}

void Session::note(const std::string& text) {
  if (num_quiet_ > 0) return;
  const std::string line = message_line(text);
  if (std::find(told_.begin(), told_.end(), line) != told_.end()) return;
  told_.push_back(line);
  tell_(line);
}

void Session::notes(const std::vector<std::string>& texts) {
  for (const std::string& text : texts) note(text);
}

void Session::check_stop() const {
  if (stop().stop_requested()) throw Error(ErrorCode::kCancelled, "interrupted");
}

std::shared_ptr<const Dataset> Session::provided(const std::string& name) const {
  const auto found = provided_.find(name);
  return found == provided_.end() ? nullptr : found->second;
}

void Session::join(Team& team) noexcept {
  team_ = &team;
  if (team.number() != 0) Interrupt::be_silent();
}

std::string quoted(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) {
    if (!line.empty()) line += ' ';
    const bool is_plain =
        !word.empty() && std::all_of(word.begin(), word.end(), [](unsigned char c) {
          return std::isalnum(c) != 0 || std::strchr("-_./=,:+%@", c) != nullptr;
        });
    if (is_plain) {
      line += word;
      continue;
    }
    line += '\'';
    for (const char c : word) line += c == '\'' ? std::string("'\\''") : std::string(1, c);
    line += '\'';
  }
  return line;
}

bool has_ending(const std::string& path, const std::string& ending) {
  if (path.size() < ending.size()) return false;
  return std::equal(ending.rbegin(), ending.rend(), path.rbegin(), [](char a, char b) {
    return a == static_cast<char>(std::tolower(static_cast<unsigned char>(b)));
  });
}

}  // namespace ovoid::cli
