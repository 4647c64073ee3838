// SPDX-License-Identifier: Apache-2.0
// What the tests of the program share: running it, and small files to run it on.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace ovoid::cli_tests {

using Words = std::vector<std::string>;

inline std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void write_file(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

// A folder of its own for each test, gone with it.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "ovoid_cli_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) ADD_FAILURE() << "no folder " << name;
    path_ = name;
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  std::size_t num_files() const {
    std::filesystem::directory_iterator first(path_);
    return static_cast<std::size_t>(std::distance(begin(first), end(first)));
  }

 private:
  std::filesystem::path path_;
};

struct Outcome {
  int exit_code = -1;  // 128 + signal if one ended it
  std::string out;
  std::string err;

  // The lines on standard error that are no notes.
  Words error_lines() const {
    Words lines;
    std::istringstream stream(err);
    for (std::string line; std::getline(stream, line);) {
      if (line.rfind("note: ", 0) != 0) lines.push_back(line);
    }
    return lines;
  }
};

// A started program; `run` waits for it at once.
class Program {
 public:
  // `prepare` runs in the child, before it becomes the program, with its files in place.
  explicit Program(Words words, const std::string& program = OVOID_PROGRAM,
                   const std::function<void()>& prepare = {}) {
    words.insert(words.begin(), program);
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    pid_ = fork();
    if (pid_ != 0) return;
    redirect(folder_ / "out", STDOUT_FILENO);
    redirect(folder_ / "err", STDERR_FILENO);
    if (prepare) prepare();
    execv(arguments[0], arguments.data());
    _exit(127);
  }
  ~Program() {
    if (pid_ > 0) {
      kill(pid_, SIGKILL);
      waitpid(pid_, nullptr, 0);
    }
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  void send(int signal) const { kill(pid_, signal); }

  // Waits for its end; killed, with a failure, after `seconds`.
  Outcome finish(double seconds = 120) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    int status = 0;
    while (waitpid(pid_, &status, WNOHANG) == 0) {
      if (std::chrono::steady_clock::now() > deadline) {
        ADD_FAILURE() << "still running after " << seconds << " s";
        kill(pid_, SIGKILL);
        waitpid(pid_, &status, 0);
        break;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    pid_ = -1;
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    return {code, read_file(folder_ / "out"), read_file(folder_ / "err")};
  }

 private:
  static void redirect(const std::string& path, int descriptor) {
    dup2(open(path.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0600), descriptor);
  }

  Folder folder_;
  pid_t pid_ = -1;
};

inline Outcome run(const Words& words, const std::string& program = OVOID_PROGRAM) {
  return Program(words, program).finish();
}

inline Outcome run_after(const std::function<void()>& prepare, const Words& words) {
  return Program(words, OVOID_PROGRAM, prepare).finish();
}

inline std::string joined(const Words& words) {
  std::string line = "ovoid";
  for (const std::string& word : words) line += ' ' + word;
  return line;
}

// The contract of a failure: exit code, one line that starts as promised and holds every fragment,
// nothing on standard output.
inline void expect_failure(const Words& words, int exit_code, const Words& fragments) {
  SCOPED_TRACE(joined(words));
  const Outcome result = run(words);
  EXPECT_EQ(result.exit_code, exit_code) << result.err;
  EXPECT_EQ(result.out, "");
  const Words lines = result.error_lines();
  ASSERT_EQ(lines.size(), 1U) << result.err;
  EXPECT_EQ(lines[0].rfind("ovoid: error: ", 0), 0U) << lines[0];
  for (const std::string& fragment : fragments) {
    EXPECT_NE(lines[0].find(fragment), std::string::npos)
        << '\'' << fragment << "' not in: " << lines[0];
  }
}

inline void expect_success(const Words& words) {
  SCOPED_TRACE(joined(words));
  const Outcome result = run(words);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.error_lines(), Words{}) << result.err;
}

// An 8-bit ball of radius 6 in 16^3 samples, 0 outside and up to 255 in the middle.
inline std::string ball_bytes() {
  std::string bytes;
  for (int k = 0; k < 16; ++k) {
    for (int j = 0; j < 16; ++j) {
      for (int i = 0; i < 16; ++i) {
        const double r =
            std::sqrt((i - 7.5) * (i - 7.5) + (j - 7.5) * (j - 7.5) + (k - 7.5) * (k - 7.5));
        bytes.push_back(
            static_cast<char>(static_cast<std::uint8_t>(std::max(0.0, 255 * (1 - r / 6)))));
      }
    }
  }
  return bytes;
}

// Writes the ball under a name that says what it is; returns the path.
inline std::string write_ball(const Folder& folder) {
  const std::string path = folder / "ball_16x16x16_uint8.raw";
  write_file(path, ball_bytes());
  return path;
}

// A float picture as `ovoid render -o x.npy` writes it.
struct Picture {
  int width = 0;
  int height = 0;
  std::vector<float> rgba;

  const float* at(int x, int y) const {
    return &rgba[4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                      static_cast<std::size_t>(x))];
  }
  std::size_t num_covered() const {
    std::size_t covered = 0;
    for (std::size_t i = 3; i < rgba.size(); i += 4) covered += rgba[i] > 0 ? 1U : 0U;
    return covered;
  }
};

inline Picture read_npy(const std::string& path) {
  const std::string bytes = read_file(path);
  Picture picture;
  if (bytes.size() < 10 || bytes.compare(0, 6, "\x93NUMPY") != 0) {
    ADD_FAILURE() << path << " is no NPY file";
    return picture;
  }
  const std::size_t length =
      static_cast<std::uint8_t>(bytes[8]) + 256U * static_cast<std::uint8_t>(bytes[9]);
  const std::string header = bytes.substr(10, length);
  EXPECT_NE(header.find("'<f4'"), std::string::npos) << header;
  EXPECT_NE(header.find("'fortran_order': False"), std::string::npos) << header;
  const std::size_t shape = header.find("'shape': (");
  int channels = 0;
  EXPECT_EQ(std::sscanf(header.c_str() + shape, "'shape': (%d, %d, %d)", &picture.height,
                        &picture.width, &channels),
            3)
      << header;
  EXPECT_EQ(channels, 4);
  picture.rgba.resize((bytes.size() - 10 - length) / sizeof(float));
  EXPECT_EQ(picture.rgba.size(), 4U * static_cast<std::size_t>(picture.width) *
                                     static_cast<std::size_t>(picture.height));
  std::memcpy(picture.rgba.data(), bytes.data() + 10 + length, picture.rgba.size() * sizeof(float));
  return picture;
}

// Draws with a small size and returns the float picture.
inline Picture draw(const Folder& folder, Words words) {
  const std::string path = folder / "drawn.npy";
  words.insert(words.begin(), "render");
  words.insert(words.end(), {"-o", path});
  if (std::find(words.begin(), words.end(), "--size") == words.end())
    words.insert(words.end(), {"--size", "40x30"});
  expect_success(words);
  return read_npy(path);
}

// What `ovoid info --json` says of an input.
inline nlohmann::json facts_of(const std::string& path, Words more = {}) {
  more.insert(more.begin(), {"info", path, "--json"});
  const Outcome result = run(more);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return nlohmann::json::parse(result.out, nullptr, false);
}

inline bool has_hdf5() {
  const Folder folder;
  return run({"make", "flat", "--size", "4", "-o", folder / "a.h5"}).exit_code == 0;
}

// Real data next to the project, or "" if it is not there.
inline std::string real_data(const std::string& name) {
  const char* const folder = std::getenv("OVOID_DATA");
  const std::filesystem::path base =
      folder != nullptr ? folder : std::filesystem::path(OVOID_SOURCE_DIR) / "../shared/data";
  const std::filesystem::path path = base / name;
  return std::filesystem::exists(path) ? path.string() : "";
}

}  // namespace ovoid::cli_tests
