// SPDX-License-Identifier: Apache-2.0
// Fails if the help texts and docs/command-line.md part ways, or if the program's first word is not
// understood as documented.
#include <gtest/gtest.h>

#include "ovoid/renderer.h"
#include "program.h"

namespace ovoid::cli_tests {
namespace help_test {

const char* const kCommands[] = {
    "render", "animate", "info", "make", "convert", "fit", "sample", "bench",
#ifdef OVOID_VIEWER
    "view",  // a program of its own, which lies beside this one
#endif
};

TEST(Help, StandsWordForWordInTheDocs) {
  const std::string docs = read_file(OVOID_SOURCE_DIR "/docs/command-line.md");
  for (const char* const command : kCommands) {
    const Outcome help = run({command, "--help"});
    EXPECT_EQ(help.exit_code, 0);
    EXPECT_EQ(help.err, "");
    EXPECT_NE(docs.find("```text\n" + help.out + "```"), std::string::npos)
        << "docs/command-line.md does not hold the output of: ovoid " << command << " --help\n"
        << help.out;
    EXPECT_EQ(run({command, "-h"}).out, help.out);
  }
}

TEST(Help, FitsATerminal) {
  for (const char* const command : kCommands) {
    std::istringstream lines(run({command, "--help"}).out);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80U) << line;
  }
}

TEST(Help, WhatBackEndsDrawIsInTheDocs) {
  std::string table = "| feature | reference | cpu | vulkan |\n|---|---|---|---|\n";
  const auto word = [](bool draws) { return draws ? "yes" : "no"; };
  for (const BackEndFeature& row : back_end_features()) {
    table += std::string("| ") + row.name + " | " + word(row.by_reference) + " | " +
             word(row.by_cpu) + " | " + word(row.by_vulkan) + " |\n";
  }
  const std::string docs = read_file(OVOID_SOURCE_DIR "/docs/devices.md");
  EXPECT_NE(docs.find(table), std::string::npos) << "docs/devices.md does not hold\n" << table;
}

TEST(Help, ListsEveryCommand) {
  const Outcome help = run({"--help"});
  EXPECT_EQ(help.exit_code, 0);
  for (const char* const command : kCommands) {
    EXPECT_NE(help.out.find(std::string("ovoid ") + command), std::string::npos) << command;
  }
  EXPECT_NE(help.out.find("ovoid view INPUT..."), std::string::npos);
  EXPECT_NE(help.out.find("ovoid INPUT..."), std::string::npos);
}

TEST(Help, VersionIsOneLine) {
  const Outcome version = run({"--version"});
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_EQ(version.out.rfind("ovoid ", 0), 0U) << version.out;
  EXPECT_EQ(std::count(version.out.begin(), version.out.end(), '\n'), 1);
}

TEST(Help, NoCommandIsAnError) { expect_failure({}, 2, {"no command", "ovoid --help"}); }

TEST(Help, UnknownCommandsGetTheNearest) {
  expect_failure({"rendr", "x.nrrd"}, 2, {"'rendr'", "unknown command", "did you mean render?"});
  expect_failure({"--versoin"}, 2, {"'--versoin'", "unknown flag"});
}

}  // namespace help_test
}  // namespace ovoid::cli_tests
