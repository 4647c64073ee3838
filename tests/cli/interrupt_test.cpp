// SPDX-License-Identifier: Apache-2.0
// Ctrl-C: the program ends with 130 and leaves no file. Fails if a signal is lost, ends the program
// half-way through a file, or is only noticed when the work is done.
#include <gtest/gtest.h>

#include "program.h"

namespace ovoid::cli_tests {
namespace {

// Hours of work: the reference takes every sample of a large picture.
Words endless(const Folder& folder, const std::string& ball) {
  return {"render",    ball,        "-o",        folder / "out.png",    "--size",
          "8000x8000", "--backend", "reference", "--sampling-distance", "0.001"};
}

TEST(Interrupt, CtrlCStopsWithoutAFile) {
  const Folder folder;
  const std::string ball = write_ball(folder);
  for (const int signal : {SIGINT, SIGTERM}) {
    Program program(endless(folder, ball));
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    program.send(signal);
    const Outcome result = program.finish(20);
    EXPECT_EQ(result.exit_code, 130) << result.err;
    ASSERT_EQ(result.error_lines().size(), 1U) << result.err;
    EXPECT_EQ(result.error_lines()[0].rfind("ovoid: error: ", 0), 0U) << result.err;
    EXPECT_EQ(folder.num_files(), 1U) << "a file was left";
  }
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

}  // namespace
}  // namespace ovoid::cli_tests
