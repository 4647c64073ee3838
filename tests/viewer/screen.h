// SPDX-License-Identifier: Apache-2.0
// What the tests of the window share: a virtual screen, running the viewer with a script on it, and
// small data to show.
#pragma once

#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "cli/program.h"

namespace ovoid::viewer_tests {

using cli_tests::Folder;
using cli_tests::Outcome;
using cli_tests::Program;
using cli_tests::read_file;
using cli_tests::Words;
using cli_tests::write_file;

// Of a script's run; software OpenGL takes a tenth of it for the longest one.
inline constexpr double kLimitSeconds = 60;

// One for the whole executable, started when the first test asks for it. Ends with the executable,
// however that ends.
class Screen {
 public:
  static Screen& get() {
    static Screen screen;
    return screen;
  }
  bool is_there() const { return !display_.empty(); }
  const std::string& display() const { return display_; }

  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

 private:
  Screen() {
    int ends[2];
    if (pipe(ends) != 0) return;
    const pid_t parent = getpid();
    pid_ = fork();
    if (pid_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      if (getppid() != parent) _exit(1);
      close(ends[0]);
      const int nowhere = open("/dev/null", O_RDWR);
      for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        dup2(nowhere, descriptor);
      const std::string descriptor = std::to_string(ends[1]);
      execlp("Xvfb", "Xvfb", "-displayfd", descriptor.c_str(), "-screen", "0", "1280x1024x24",
             "-nolisten", "tcp", "-noreset", static_cast<char*>(nullptr));
      _exit(127);
    }
    close(ends[1]);
    std::string number;
    for (char c = 0; read(ends[0], &c, 1) == 1 && c != '\n';) number += c;
    close(ends[0]);
    if (number.empty()) return;
    display_ = ":" + number;
    setenv("DISPLAY", display_.c_str(), 1);
    setenv("LIBGL_ALWAYS_SOFTWARE", "1", 1);
    unsetenv("WAYLAND_DISPLAY");
  }
  ~Screen() {
    if (pid_ <= 0) return;
    kill(pid_, SIGTERM);
    waitpid(pid_, nullptr, 0);
  }

  pid_t pid_ = -1;
  std::string display_;
};

// A run of the viewer: what its script printed, beside the rest.
struct Viewed {
  Outcome outcome;
  std::map<std::string, std::vector<std::string>> printed;

  void take(Outcome of) {
    outcome = std::move(of);
    std::istringstream lines(outcome.out);
    for (std::string line; std::getline(lines, line);) {
      const std::size_t equals = line.find(" = ");
      if (equals != std::string::npos)
        printed[line.substr(0, equals)].push_back(line.substr(equals + 3));
    }
  }
  // Of the first, second ... time that it was printed.
  std::string text(const std::string& key, std::size_t time = 0) const {
    const auto found = printed.find(key);
    if (found == printed.end() || time >= found->second.size()) {
      ADD_FAILURE() << key << " was not printed " << time + 1 << " times";
      return "";
    }
    return found->second[time];
  }
  double number(const std::string& key, std::size_t time = 0) const {
    return std::atof(text(key, time).c_str());
  }
  nlohmann::json json(const std::string& key, std::size_t time = 0) const {
    return nlohmann::json::parse(text(key, time), nullptr, false);
  }
};

inline std::string bin_folder() {
  return std::filesystem::path(OVOID_VIEWER_PROGRAM).parent_path().string();
}

class OnScreen : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!Screen::get().is_there()) GTEST_SKIP() << "there is no Xvfb to show a window on";
  }

  // Sample data by formula; returns the path. Of "head" 48^3 samples.
  std::string make(const std::string& name, const std::string& file, const Words& more = {}) {
    Words words = {"make", name, "-o", folder_ / file};
    words.insert(words.end(), more.begin(), more.end());
    cli_tests::expect_success(words);
    return folder_ / file;
  }
  std::string make_head() { return make("head", "head.nrrd", {"--size", "48"}); }

  Words words_of(Words words, const std::string& script) const {
    const std::string path = folder_ / "script.txt";
    write_file(path, script);
    if (std::find(words.begin(), words.end(), "--size") == words.end())
      words.insert(words.end(), {"--size", "340x240"});
    if (std::find(words.begin(), words.end(), "--state") == words.end() &&
        std::find(words.begin(), words.end(), "--backend") == words.end())
      words.insert(words.end(), {"--backend", "cpu"});
    words.insert(words.end(), {"--script", path});
    return words;
  }

  // Replays the script; "$/" in it stands for the test's folder.
  Viewed replay(const Words& words, std::string script,
                double limit_seconds = kLimitSeconds) const {
    for (std::size_t at = 0; (at = script.find("$/", at)) != std::string::npos;)
      script.replace(at, 2, folder_ / "");
    Viewed viewed;
    viewed.take(Program(words_of(words, script), OVOID_VIEWER_PROGRAM).finish(limit_seconds));
    return viewed;
  }

  // The same of a script that must come to its end without a complaint.
  Viewed view(const Words& words, const std::string& script,
              double limit_seconds = kLimitSeconds) const {
    Viewed viewed = replay(words, script, limit_seconds);
    EXPECT_EQ(viewed.outcome.exit_code, 0);
    EXPECT_EQ(viewed.outcome.err, "");
    return viewed;
  }

  std::string file(const std::string& name) const { return read_file(folder_ / name); }

  // Of a script whose picture, command and state expect_same() takes.
  static constexpr const char* kSave =
      "picture $/window.png\nkey ctrl+c\nprint clipboard\nstate $/s.json\n";

  // The copied command, and the state, draw the picture of the window, byte for byte.
  void expect_same(const Viewed& viewed, const std::string& picture,
                   const std::string& state) const {
    const std::string command = viewed.text("clipboard");
    const Outcome outcome = cli_tests::run({"-c", "cd '" + (folder_ / "") + "' && PATH='" +
                                                      bin_folder() + "':\"$PATH\" && " + command},
                                           "/bin/sh");
    EXPECT_EQ(outcome.exit_code, 0) << command << '\n' << outcome.err;
    EXPECT_TRUE(file("picture.png") == file(picture)) << command;
    cli_tests::expect_success(
        {"render", "--state", folder_ / state, "-o", folder_ / "state.png", "--backend", "cpu"});
    EXPECT_TRUE(file("state.png") == file(picture)) << file(state);
  }

  Folder folder_;
};

inline double distance(const nlohmann::json& a, const nlohmann::json& b) {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i)
    sum += std::pow(a.at(i).get<double>() - b.at(i).get<double>(), 2);
  return std::sqrt(sum);
}

}  // namespace ovoid::viewer_tests
