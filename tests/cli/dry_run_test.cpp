// SPDX-License-Identifier: Apache-2.0
// What a picture will cost, told before it is drawn; and what shells are told.
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "program.h"

namespace ovoid::cli_tests {
namespace dry_run_test {

// The number behind "about" in a row of the answer, in MiB.
double mebibytes_in(const std::string& text, const std::string& row) {
  const auto place = text.find("about ", text.find(row));
  if (place == std::string::npos) return -1;
  double number = 0;
  std::string unit;
  std::istringstream(text.substr(place + 6)) >> number >> unit;
  return unit == "GiB" ? 1024 * number : unit == "MiB" ? number : -1;
}

TEST(DryRun, TellsWhatAFrameNeedsAndWritesNothing) {
  const Folder folder;
  const std::string ball = write_ball(folder);
  const std::size_t num_files = folder.num_files();
  const std::string path = folder / "x.png";
  const Outcome result =
      run({"render", ball, "--dry-run", "-o", path, "--size", "1600x1200", "--backend", "cpu"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(folder.num_files(), num_files);
  for (const char* const row : {"picture", "kernels", "memory of the field", "sampling distance",
                                "samples", "time of a frame", "greatest memory"}) {
    EXPECT_NE(result.out.find(row), std::string::npos) << row;
  }
  // The frame itself, for comparison: within 15 %.
  const std::string profile_path = folder / "p.json";
  const Outcome drawn = run({"render", ball, "-o", path, "--size", "1600x1200", "--backend", "cpu",
                             "--profile=" + profile_path});
  EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
  const auto profile = nlohmann::json::parse(read_file(profile_path));
  const double peak = profile["peak_memory_bytes"].get<double>() / (1 << 20);
#ifndef OVOID_SANITIZED_ADDRESS  // which keeps what was freed
  EXPECT_NEAR(mebibytes_in(result.out, "greatest memory"), peak, 0.15 * peak);
#else
  EXPECT_GT(mebibytes_in(result.out, "greatest memory"), 0.5 * peak);
#endif
}

TEST(DryRun, NeedsNoOutput) {
  const Folder folder;
  EXPECT_EQ(run({"render", write_ball(folder), "--dry-run"}).exit_code, 0);
}

// Every flag of a command's help, one a line, with tabs between.
TEST(Completion, ProgramListsItsCommandsAndFlags) {
  const Outcome commands = run({"--list-flags"});
  EXPECT_EQ(commands.exit_code, 0);
  for (const char* const command :
       {"view\t", "render\t", "info\t", "make\t", "convert\t", "bench\t"})
    EXPECT_NE(commands.out.find(command), std::string::npos) << command;
  const Outcome flags = run({"render", "--list-flags"});
  EXPECT_EQ(flags.exit_code, 0);
  EXPECT_NE(flags.out.find("-o,--output\tOUT\t"), std::string::npos);
  EXPECT_NE(flags.out.find("--slab\tauto|mid|mean\t"), std::string::npos);
  EXPECT_NE(flags.out.find("--no-shade\t\t"), std::string::npos);
}

std::string completed(const std::string& line) {
  const std::string script =
      "PATH=\"$(dirname '" OVOID_PROGRAM "'):$PATH\"; source '" OVOID_SOURCE_DIR
      "/apps/ovoid/completion/ovoid.bash'; COMP_WORDS=(" +
      line + "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _ovoid; echo \"${COMPREPLY[@]}\"";
  const Folder folder;
  write_file(folder / "script", script);
  // In that folder, for the first word may be a file, too.
  const std::string command = "cd '" + (folder / "") + "' && bash '" + (folder / "script") +
                              "' > '" + (folder / "out") + "' 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0);
  return read_file(folder / "out");
}

TEST(Completion, BashCompletesCommandsFlagsAndChoices) {
  if (std::system("command -v bash > /dev/null") != 0) GTEST_SKIP() << "no bash here";
  EXPECT_EQ(completed("ovoid ren"), "render\n");
  EXPECT_EQ(completed("ovoid render --samp"), "--sampling-distance\n");
  EXPECT_EQ(completed("ovoid render x.nrrd --slab m"), "mid mean\n");
  EXPECT_EQ(completed("ovoid vie"), "view\n");
  EXPECT_EQ(completed("ovoid render --stat"), "--state\n");
  EXPECT_EQ(completed("ovoid render x.nrrd --azimuth ''"), "\n");  // a number: nothing to offer
}

}  // namespace dry_run_test
}  // namespace ovoid::cli_tests
