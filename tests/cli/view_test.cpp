// SPDX-License-Identifier: Apache-2.0
// `ovoid view` and a file without a command: which program they start, and with which words. The
// program is copied, so that the tests choose what lies beside it.
#include <gtest/gtest.h>

#include "program.h"

namespace ovoid::cli_tests {
namespace view_test {

std::string copied_program(const Folder& folder) {
  const std::string program = folder / "ovoid";
  std::filesystem::copy_file(OVOID_PROGRAM, program);
  // With its library, if that is a shared one.
  for (const auto& file :
       std::filesystem::directory_iterator(std::filesystem::path(OVOID_PROGRAM).parent_path())) {
    const std::string name = file.path().filename();
    if (name.starts_with("libovoid.so")) std::filesystem::copy_file(file, folder / name);
  }
  return program;
}

// A viewer that tells its words, one a line.
void write_viewer(const Folder& folder) {
  const std::string viewer = folder / "ovoid-viewer";
  write_file(viewer, "#!/bin/sh\nprintf '<%s>\\n' \"$@\"\nexit 7\n");
  std::filesystem::permissions(viewer, std::filesystem::perms::owner_all);
}

TEST(View, HandsTheWordsToTheViewerBesideTheProgram) {
  const Folder folder;
  const std::string program = copied_program(folder);
  write_viewer(folder);
  const std::string ball = write_ball(folder);
  const Outcome viewed = run({"view", ball, "--size", "64 x", "--help"}, program);
  EXPECT_EQ(viewed.exit_code, 7) << viewed.err;
  EXPECT_EQ(viewed.out, "<" + ball + ">\n<--size>\n<64 x>\n<--help>\n");
  EXPECT_EQ(run({ball, "--no-shade"}, program).out, "<" + ball + ">\n<--no-shade>\n");
  EXPECT_EQ(run({"view"}, program).out, "<>\n");  // printf without words
  EXPECT_EQ(run({"view"}, program).exit_code, 7);
}

// A session blocks signals, and what is started then would, too.
TEST(View, TheViewerCanBeInterrupted) {
  const Folder folder;
  const std::string program = copied_program(folder);
  const std::string viewer = folder / "ovoid-viewer";
  write_file(viewer, "#!/bin/sh\nkill -INT $$\nsleep 5\nexit 7\n");
  std::filesystem::permissions(viewer, std::filesystem::perms::owner_all);
  EXPECT_EQ(run({"view"}, program).exit_code, 128 + SIGINT);
}

TEST(View, WithoutAViewerOneLineSaysSo) {
  const Folder folder;
  const std::string program = copied_program(folder);
  const std::string ball = write_ball(folder);
  const std::string said =
      "ovoid: error: view: the viewer is not part of this installation, there "
      "is no " +
      (folder / "ovoid-viewer") +
      ": in the source folder, make build makes it; to draw to a file: ovoid render INPUT... -o "
      "OUT.png\n";
  for (const Words& words : {Words{"view", ball}, Words{ball}, Words{"view"}}) {
    const Outcome result = run(words, program);
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_EQ(result.err, said);
    EXPECT_EQ(result.out, "");
  }
}

TEST(View, OtherFirstWordsAreStillErrors) {
  const Folder folder;
  const std::string program = copied_program(folder);
  write_viewer(folder);
  const Outcome unknown = run({"rendr"}, program);
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_NE(unknown.err.find("unknown command; did you mean render?"), std::string::npos);
  const Outcome missing = run({folder / "missing.nrrd"}, program);
  EXPECT_EQ(missing.exit_code, 2);
  EXPECT_EQ(missing.out, "");
}

}  // namespace view_test
}  // namespace ovoid::cli_tests
