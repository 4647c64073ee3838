// SPDX-License-Identifier: Apache-2.0
// Memory that runs out, wherever it does: the program is run under limits from where it barely
// starts to where it finishes. Fails on a crash, on an exception that nobody catches, on another
// exit code than 0 or 3, on more than one line, and on a file that is left.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include "program.h"

namespace ovoid::cli_tests {
namespace memory_test {

constexpr rlim_t kMiB = rlim_t{1} << 20;

Outcome run_within(rlim_t bytes, const Words& words) {
  return run_after(
      [bytes] {
        const rlimit limit{bytes, bytes};
        setrlimit(RLIMIT_AS, &limit);
      },
      words);
}

// The least limit, in MiB, within which the program starts; 0 if it does not within 4 GiB, as with
// AddressSanitizer.
rlim_t least_to_start() {
  rlim_t below = 0, enough = 4096;
  if (run_within(enough * kMiB, {"--version"}).exit_code != 0) return 0;
  while (enough - below > 1) {
    const rlim_t middle = (below + enough) / 2;
    (run_within(middle * kMiB, {"--version"}).exit_code == 0 ? enough : below) = middle;
  }
  return enough;
}

struct Command {
  Words words;
  std::string output;  // empty: none
};

// Step by step from where it starts, until it finishes three times in a row; how often it did not.
int sweep(const Command& command, rlim_t first, rlim_t step) {
  const Folder out;
  Words words = command.words;
  if (!command.output.empty()) words.insert(words.end(), {"-o", out / command.output});
  SCOPED_TRACE(joined(words));
  int failures = 0;
  for (int finished = 0; finished < 3 && !testing::Test::HasFailure(); first += step) {
    if (!command.output.empty()) std::filesystem::remove(out / command.output);
    const Outcome result = run_within(first * kMiB, words);
    const bool is_done = result.exit_code == 0;
    finished = is_done ? finished + 1 : 0;
    if (is_done) continue;
    ++failures;
    EXPECT_LT(first, 8192U);
    EXPECT_EQ(result.exit_code, 3) << first << " MiB: " << result.err;
    EXPECT_EQ(result.error_lines().size(), 1U) << first << " MiB: " << result.err;
    EXPECT_EQ(out.num_files(), 0U) << first << " MiB left a file";
  }
  return failures;
}

class Memory : public testing::Test {
 protected:
  void SetUp() override {
    least_ = least_to_start();
    if (least_ == 0) GTEST_SKIP() << "this program cannot be limited";
  }
  void sweep_all(const std::vector<Command>& commands) const {
    const char* const step = std::getenv("OVOID_TEST_MEMORY_STEP");  // MiB
    int failures = 0;
    for (const Command& command : commands)
      failures += sweep(command, least_, step != nullptr ? std::strtoul(step, nullptr, 10) : 5);
    EXPECT_GT(failures, 0) << "the sweep began too high";
  }
  Folder folder_;
  rlim_t least_ = 0;
};

TEST_F(Memory, OfLattices) {
  const std::string path = folder_ / "a.nrrd";
  expect_success({"make", "head", "-o", path, "--size", "64"});
  sweep_all({{{"info", path}, ""},
             {{"render", path, "--backend", "cpu", "--threads", "3", "--size", "640x480"}, "o.png"},
             {{"render", path, "--backend", "reference", "--threads", "2", "--size", "4x3",
               "--sampling-distance", "8"},
              "o.exr"},
             {{"convert", path}, "o.nii.gz"},
             {{"convert", path}, "o.h5"},
             {{"convert", path, "--size", "64", "--threads", "2"}, "o.nrrd"}});
}

// Fails if samples that memory does not hold are read all the same, or if the picture is another's.
TEST_F(Memory, LargerLatticesAreDrawnFromTheirFile) {
  // HDF5's samples are deflated in chunks, and its reader's process takes more than the program.
  const std::vector<std::pair<const char*, rlim_t>> files = {{"a_320x320x640_uint8.raw", 53},
                                                             {"a.h5", 125}};
  for (const auto& [name, room] : files) {
    const std::string path = folder_ / name;
    if (path.ends_with(".h5") && !has_hdf5()) continue;
    expect_success({"make", "head", "--size", "320x320x640", "--type", "uint8", "-o", path});
    const Words render{
        "render",      path,     "--backend",          "cpu", "--threads", "2",
        "--size",      "100x80", "--post-convolution", "off",  // in memory there would be levels
        "--occlusion", "0"};                                   // and room for the light
    Words within = render, whole = render;
    within.insert(within.end(), {"-o", folder_ / "within.png"});
    whole.insert(whole.end(), {"--kernel", "catmull-rom", "-o", folder_ / "whole.png"});
    const rlim_t limit = (least_ + room) * kMiB;  // of samples of 62.5
    const Outcome result = run_within(limit, within);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_NE(result.err.find("65536000 samples are read from a file"), std::string::npos)
        << result.err;
    EXPECT_EQ(result.err.find("/proc"), std::string::npos) << result.err;
    expect_success(whole);
    EXPECT_EQ(read_file(folder_ / "within.png"), read_file(folder_ / "whole.png"));
    const Outcome info = run_within(limit, {"info", path});
    EXPECT_NE(info.out.find(": uint8, 0 to 2"), std::string::npos) << info.out << info.err;
    // What needs all samples says so.
    within.insert(within.end(), {"--kernel", "bspline"});
    const Outcome refused = run_within(limit, within);
    EXPECT_EQ(refused.exit_code, 3);
    EXPECT_NE(refused.err.find("no memory for coefficients"), std::string::npos) << refused.err;
    if (path.ends_with(".raw"))
      EXPECT_EQ(run_within(limit, {"convert", path, "-o", folder_ / "a.nii"}).exit_code, 3);
  }
}

TEST_F(Memory, OfParticles) {
  const std::string path = folder_ / "a.npz";
  expect_success({"make", "galaxy", "-o", path});
  sweep_all({{{"info", path}, ""},
             {{"render", path, "--backend", "cpu", "--threads", "3", "--size", "320x240"}, "o.png"},
             {{"convert", path}, "o.csv"}});
}

TEST_F(Memory, OfKernels) {
  const std::string path = folder_ / "a.ply";
  expect_success({"make", "blobs", "-o", path});
  sweep_all({{{"info", path}, ""},
             {{"render", path, "--backend", "cpu", "--threads", "3", "--size", "320x240"}, "o.png"},
             {{"convert", path, "--size", "48"}, "o.npy"}});
}

}  // namespace memory_test
}  // namespace ovoid::cli_tests
