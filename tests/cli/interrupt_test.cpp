// SPDX-License-Identifier: Apache-2.0
// Ctrl-C: the program ends with 128 and the signal's number and leaves no file. Fails if a signal
// is lost, ends the program half-way through a file, or is only noticed when the work is done.
#include <gtest/gtest.h>

#include <sys/resource.h>

#include <random>

#include "program.h"

namespace ovoid::cli_tests {
namespace interrupt_test {

// Hours of work: the reference takes every sample of a large picture.
Words endless(const Folder& folder, const std::string& ball) {
  return {"render",    ball,        "-o",        folder / "out.png",    "--size",
          "8000x8000", "--backend", "reference", "--sampling-distance", "0.001"};
}

TEST(Interrupt, CtrlCStopsWithoutAFile) {
  const Folder folder;
  const std::string ball = write_ball(folder);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    Program program(endless(folder, ball));
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    program.send(signal);
    const Outcome result = program.finish(20);
    EXPECT_EQ(result.exit_code, 128 + signal) << result.err;
    ASSERT_EQ(result.error_lines().size(), 1U) << result.err;
    EXPECT_EQ(result.error_lines()[0].rfind("ovoid: error: ", 0), 0U) << result.err;
    EXPECT_EQ(folder.num_files(), 1U) << "a file was left";
  }
}

// Noise, which takes seconds to pack.
std::string write_noise(const Folder& folder) {
  std::mt19937_64 random(16);
  std::string bytes(std::size_t{480} * 480 * 480, '\0');
  for (std::size_t i = 0; i + 8 <= bytes.size(); i += 8) {
    const std::uint64_t number = random();
    std::memcpy(&bytes[i], &number, 8);
  }
  const std::string path = folder / "noise_480x480x480_uint8.raw";
  write_file(path, bytes);
  return path;
}

// The signal comes once the partial file is there.
TEST(Interrupt, WritersStop) {
  const Folder folder;
  const std::string noise = write_noise(folder);
  for (const char* const name : {"out.nii.gz", "out.vti", "out.h5"}) {
    for (const int signal : {SIGINT, SIGTERM}) {
      SCOPED_TRACE(name);
      Program program({"convert", noise, "-o", folder / name});
      for (int i = 0; i < 10000 && folder.num_files() < 2; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
      program.send(signal);
      const Outcome result = program.finish(60);
      if (result.exit_code == 1 || result.exit_code == 2) continue;  // no library for the format
      EXPECT_EQ(result.exit_code, 128 + signal) << result.err;
      EXPECT_EQ(result.error_lines().size(), 1U) << result.err;
      EXPECT_EQ(folder.num_files(), 1U) << "a file was left";
    }
  }
}

TEST(Interrupt, AFileThatMayNotGrowIsAnError) {
  const Folder folder;
  const std::string ball = write_ball(folder);
  for (const char* const name : {"out.nrrd", "out.nhdr", "out.vti", "out.h5", "out.nii"}) {
    const Outcome result = run_after(
        [] {
          const rlimit limit{512, 512};
          setrlimit(RLIMIT_FSIZE, &limit);
        },
        {"convert", ball, "-o", folder / name});
    if (result.exit_code == 2) continue;  // no library for the format
    EXPECT_EQ(result.exit_code, 1) << result.err;
    EXPECT_EQ(folder.num_files(), 1U) << name << " left a file";
  }
}

TEST(Interrupt, APipeThatNobodyReadsIsAnError) {
  const Folder folder;
  const Outcome result = run_after(
      [] {
        int ends[2];
        if (pipe(ends) != 0) _exit(126);
        close(ends[0]);
        dup2(ends[1], STDOUT_FILENO);
      },
      {"info", write_ball(folder)});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(result.err, "ovoid: error: standard output: cannot be written: Broken pipe\n");
}

TEST(Interrupt, TimedFramesStopToo) {
  const Folder folder;
  Program program({"render", write_ball(folder), "-o", folder / "out.png", "--size", "64x64",
                   "--repeat", "100000"});
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  program.send(SIGINT);
  EXPECT_EQ(program.finish(20).exit_code, 130);
  EXPECT_EQ(folder.num_files(), 1U);
}

}  // namespace interrupt_test
}  // namespace ovoid::cli_tests
