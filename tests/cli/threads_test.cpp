// SPDX-License-Identifier: Apache-2.0
// Threads that cannot be made: the work is done with fewer. Fails on a crash, on a picture that is
// not the same, and without the note.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cstdlib>

#include "program.h"

namespace ovoid::cli_tests {
namespace threads_test {

// A user of its own, who may have this many threads: limits do not hold for the superuser, and
// those of tests that run beside this one would count.
std::function<void()> with_threads(rlim_t count) {
  const uid_t nobody_else = 1'000'000 + static_cast<uid_t>(getpid());
  return [count, nobody_else] {
    const rlimit limit{count, count};
    setrlimit(RLIMIT_NPROC, &limit);
    setenv("ASAN_OPTIONS", "detect_leaks=0", 1);  // the search takes a thread of its own
    if (setgid(nobody_else) != 0 || setuid(nobody_else) != 0) _exit(126);
  };
}

TEST(Threads, FewerDrawTheSame) {
  if (geteuid() != 0) GTEST_SKIP() << "only the superuser becomes a user without other processes";
  const Folder folder;
  const std::string ball = write_ball(folder);
  std::filesystem::permissions(folder / "", std::filesystem::perms::all);
  for (const char* const backend : {"cpu", "reference"}) {
    const Words words = {"render", ball,        "-o",    folder / "a.png", "--size",
                         "64x64",  "--backend", backend, "--threads",      "16"};
    expect_success(words);
    const std::string whole = read_file(folder / "a.png");
    std::filesystem::remove(folder / "a.png");
    for (const rlim_t count : {1, 2, 3, 6}) {
      SCOPED_TRACE(std::string(backend) + " with " + std::to_string(count));
      const Outcome result = run_after(with_threads(count), words);
      EXPECT_EQ(result.exit_code, 0) << result.err;
      EXPECT_NE(result.err.find("note: threads: 16 were wanted, the system grants"),
                std::string::npos)
          << result.err;
      EXPECT_EQ(result.error_lines(), Words{});
      EXPECT_EQ(read_file(folder / "a.png"), whole);
      std::filesystem::remove(folder / "a.png");
    }
  }
}

TEST(Threads, OtherCommandsNeedNone) {
  if (geteuid() != 0) GTEST_SKIP() << "only the superuser becomes a user without other processes";
  const Folder folder;
  const std::string ball = write_ball(folder);
  std::filesystem::permissions(folder / "", std::filesystem::perms::all);
  const std::vector<Words> commands = {
      {"info", ball},
      {"convert", ball, "--size", "20", "--threads", "16", "-o", folder / "a.nrrd"},
      {"animate", ball, "--turn", "360", "--frames", "2", "--size", "32x32", "--backend", "cpu",
       "-o", folder / "f%d.png"}};
  for (const Words& words : commands) {
    const Outcome result = run_after(with_threads(1), words);
    EXPECT_EQ(result.exit_code, 0) << joined(words) << result.err;
    EXPECT_EQ(result.error_lines(), Words{});
  }
}

}  // namespace threads_test
}  // namespace ovoid::cli_tests
