// SPDX-License-Identifier: Apache-2.0
#include "file_dialog.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <initializer_list>
#include <string_view>
#include <utility>

#include "child_process.h"
#include "ovoid/error.h"

namespace ovoid::viewer {
namespace {

// The words of the dialog that prints one path a line.
std::vector<std::string> words_of(const std::string& name, const FileDialog::Question& question) {
  std::vector<std::string> words = {name, "--title", question.title};
  const auto add = [&](std::initializer_list<const char*> more) {
    words.insert(words.end(), more.begin(), more.end());
  };
  if (name == "kdialog") {
    if (question.takes_several) add({"--multiple", "--separate-output"});
    add({"--getopenfilename", question.folder.c_str()});
    return words;
  }
  add({"--file-selection"});
  if (question.takes_several) add({"--multiple", "--separator=\n"});
  words.push_back("--filename=" + question.folder + "/");
  return words;
}

// KDE's own where KDE runs.
std::array<const char*, 2> programs() {
  const char* const desktop = std::getenv("XDG_CURRENT_DESKTOP");
  const bool is_kde =
      desktop != nullptr && std::string_view(desktop).find("KDE") != std::string_view::npos;
  return is_kde ? std::array{"kdialog", "zenity"} : std::array{"zenity", "kdialog"};
}

}  // namespace

FileDialog::~FileDialog() {
  if (is_shown()) {
    kill(child_, SIGTERM);
    waitpid(child_, nullptr, 0);
  }
  close();
}

void FileDialog::show(const Question& question) {
  if (is_shown()) return;
  for (const char* const name : programs()) {
    const std::string program = cli::find_program(name);
    if (program.empty()) continue;
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) {
      throw Error(ErrorCode::kUnsupported,
                  fmt::format("{}: cannot be run: {}", program, std::strerror(errno)));
    }
    output_ = ends[0];
    fcntl(output_, F_SETFL, O_NONBLOCK);
    try {
      child_ = cli::start_program(program, words_of(name, question), {.out = ends[1], .err = {}});
    } catch (...) {
      ::close(ends[1]);
      close();
      throw;
    }
    ::close(ends[1]);
    name_ = name;
    return;
  }
  throw Error(ErrorCode::kUnsupported,
              "there is no dialog for files, neither zenity nor kdialog is installed: drop a file "
              "here, or name one in the panel's field");
}

void FileDialog::read() {
  constexpr std::size_t kMost = std::size_t{1} << 20;  // of names; what follows is passed over
  std::array<char, 4096> piece{};
  for (ssize_t size = 0; (size = ::read(output_, piece.data(), piece.size())) > 0;) {
    if (text_.size() < kMost) text_.append(piece.data(), static_cast<std::size_t>(size));
  }
}

std::optional<FileDialog::Answer> FileDialog::take() {
  if (!is_shown()) return std::nullopt;
  read();
  int status = 0;
  const pid_t ended = waitpid(child_, &status, WNOHANG);
  if (ended == 0) return std::nullopt;
  read();  // what was written since
  const std::string text = std::exchange(text_, {});
  close();
  child_ = -1;
  Answer answer;
  constexpr int kCancelled = 1;  // of both programs
  const bool is_done = ended > 0 && WIFEXITED(status) && WEXITSTATUS(status) == 0;
  if (!is_done && !(ended > 0 && WIFEXITED(status) && WEXITSTATUS(status) == kCancelled))
    answer.error = name_ + ", the dialog for files, has failed";
  if (!is_done) return answer;
  std::string_view rest = text;
  while (!rest.empty()) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    if (!line.empty()) answer.paths.emplace_back(line);
    rest.remove_prefix(std::min(rest.size(), line.size() + 1));
  }
  return answer;
}

void FileDialog::close() noexcept {
  if (output_ >= 0) ::close(std::exchange(output_, -1));
}

}  // namespace ovoid::viewer
