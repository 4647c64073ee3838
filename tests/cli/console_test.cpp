// SPDX-License-Identifier: Apache-2.0
// Standard files that are closed or full. Fails if work is lost because nobody hears of it, if an
// answer that got nowhere counts as given, or if a file gets what was meant for standard error.
#include <gtest/gtest.h>

#include "console.h"
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

// Fails if a message is as long as what a file says, or loses what it names or expects.
TEST(Console, MessagesAreOneLineOfAThousandBytes) {
  const Folder folder;
  constexpr std::size_t kMost = 1000;
  const std::string much(40000, 'x');
  const auto one = [&](const Words& words, const std::string& head, const std::string& tail) {
    const Outcome result = run(words);
    EXPECT_NE(result.exit_code, 0);
    ASSERT_EQ(result.error_lines().size(), 1U) << result.err.substr(0, 2 * kMost);
    const std::string line = result.error_lines()[0];
    EXPECT_LE(line.size(), kMost);
    EXPECT_NE(line.find(head), std::string::npos) << line;
    EXPECT_TRUE(line.ends_with(tail)) << line;
  };
  const std::string ball = write_ball(folder);
  one({"render", ball, "--" + much}, "ovoid: error: --xxx", "(see ovoid render --help)");
  write_file(folder / "s.json", "{\"ovoid\": \"0.1.0\", \"" + much + "\": 1}");
  one({"render", ball, "-o", folder / "a.png", "--state", folder / "s.json"}, "s.json", "");
  write_file(folder / "look.json", "[{\"Name\": \"" + much + "\", \"RGBPoints\": 1}]");
  one({"render", ball, "-o", folder / "a.png", "--tf", folder / "look.json"}, "look.json", "");
}

TEST(Console, AMessageIsCutBetweenCharacters) {
  std::string text = "'";
  while (text.size() < 5000) text += "\xC3\xA4";
  const std::string line = cli::message_line(text + "': expected \xE2\x82\xAC");
  EXPECT_LE(line.size(), cli::kMaxMessageSize);
  EXPECT_TRUE(line.starts_with("'\xC3\xA4"));
  EXPECT_TRUE(line.ends_with("': expected \xE2\x82\xAC"));
  const std::size_t gap = line.find(" ... ");
  ASSERT_NE(gap, std::string::npos);
  EXPECT_EQ(line[gap - 1], '\xA4');
  EXPECT_EQ(line[gap + 5], '\xC3');
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
