// SPDX-License-Identifier: Apache-2.0
// Standard files that are closed or full. Fails if work is lost because nobody hears of it, if an
// answer that got nowhere counts as given, or if a file gets what was meant for standard error.
#include <gtest/gtest.h>

#include "program.h"

namespace ovoid::cli_tests {
namespace console_test {

void close_it(int descriptor) { close(descriptor); }
void fill_it(int descriptor) { dup2(open("/dev/full", O_WRONLY), descriptor); }

TEST(Console, WhatIsDrawnIsDrawnThoughNobodyHearsOfIt) {
  const Folder folder;
  const std::string ball = write_ball(folder);
  const Words words = {
      "render", ball,        "-o",      folder / "a.png", "--size",
      "40x30",  "--profile", "--range", "300,400"};  // nothing shows, which is a note
  ASSERT_NE(run(words).err.find("note: "), std::string::npos);
  const std::string whole = read_file(folder / "a.png");
  for (const auto& spoil : {close_it, fill_it}) {
    std::filesystem::remove(folder / "a.png");
    const Outcome result = run_after([&] { spoil(STDERR_FILENO); }, words);
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_EQ(read_file(folder / "a.png"), whole);
    EXPECT_EQ(run_after([&] { spoil(STDOUT_FILENO); }, words).exit_code, 0);
  }
}

TEST(Console, ExitCodesStand) {
  const Folder folder;
  for (const auto& spoil : {close_it, fill_it}) {
    const auto code_of = [&](const Words& words) {
      return run_after([&] { spoil(STDERR_FILENO); }, words).exit_code;
    };
    EXPECT_EQ(code_of({"info", folder / "nope.nii"}), 1);
    EXPECT_EQ(code_of({"info", "--nope"}), 2);
    EXPECT_EQ(code_of({"--version"}), 0);
  }
}

TEST(Console, AnAnswerThatGetsNowhereIsAnError) {
  const Folder folder;
  const std::string ball = write_ball(folder);
  const std::vector<Words> commands = {
      {"info", ball}, {"info", ball, "--json"}, {"info", "--devices"},        {"--version"},
      {"--help"},     {"render", "--help"},     {"render", ball, "--dry-run"}};
  for (const Words& words : commands) {
    SCOPED_TRACE(joined(words));
    for (const auto& spoil : {close_it, fill_it}) {
      const Outcome result = run_after([&] { spoil(STDOUT_FILENO); }, words);
      EXPECT_EQ(result.exit_code, 1);
      ASSERT_EQ(result.error_lines().size(), 1U) << result.err;
      EXPECT_NE(result.err.find("standard output: cannot be written: "), std::string::npos)
          << result.err;
    }
  }
}

}  // namespace console_test
}  // namespace ovoid::cli_tests
