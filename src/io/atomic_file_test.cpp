// SPDX-License-Identifier: Apache-2.0
#include "io/atomic_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "io/test_folder.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid::io {
namespace {

std::string message_of(const std::string& path) {
  try {
    write_atomically(path, "x");
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kFileWrite);
    return error.what();
  }
  return "no error";
}

TEST(AtomicFile, ReplacesTheTargetOnlyAtCommit) {
  const TestFolder folder;
  folder.write("a.txt", "old");
  AtomicFile file(folder.file("a.txt"));
  file.write("new ");
  file.write("content");
  EXPECT_EQ(folder.read("a.txt"), "old");
  EXPECT_EQ(folder.count(), 2);
  file.commit();
  EXPECT_EQ(folder.read("a.txt"), "new content");
  EXPECT_EQ(folder.count(), 1);
}

TEST(AtomicFile, LeavesNothingWithoutCommit) {
  const TestFolder folder;
  folder.write("a.txt", "old");
  {
    AtomicFile file(folder.file("a.txt"));
    file.write("half");
  }
  EXPECT_EQ(folder.read("a.txt"), "old");
  EXPECT_EQ(folder.count(), 1);
}

TEST(AtomicFile, RemovePartialFilesRemovesOnlyWhatIsUnfinished) {
  const TestFolder folder;
  write_atomically(folder.file("done.txt"), "done");
  AtomicFile open_file(folder.file("open.txt"));
  open_file.write("half");
  ASSERT_EQ(folder.count(), 2);
  remove_partial_files();
  EXPECT_EQ(folder.count(), 1);
  EXPECT_EQ(folder.read("done.txt"), "done");
}

TEST(AtomicFile, MoreOpenFilesThanSlotsStillWork) {
  const TestFolder folder;
  std::vector<std::unique_ptr<AtomicFile>> files;
  for (int i = 0; i < 20; ++i) {
    files.push_back(std::make_unique<AtomicFile>(folder.file(std::to_string(i))));
  }
  for (auto& file : files) {
    file->write("x");
    file->commit();
  }
  EXPECT_EQ(folder.count(), 20);
}

TEST(AtomicFile, FollowsSymbolicLinks) {
  const TestFolder folder;
  folder.write("real.txt", "old");
  std::filesystem::create_symlink(folder.file("real.txt"), folder.file("link.txt"));
  write_atomically(folder.file("link.txt"), "new");
  EXPECT_EQ(folder.read("real.txt"), "new");
  EXPECT_TRUE(std::filesystem::is_symlink(folder.file("link.txt")));
}

TEST(AtomicFile, WritesDevicesWithoutReplacingThem) {
  write_atomically("/dev/null", "x");
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

TEST(AtomicFile, ErrorsNamePathAndReason) {
  const TestFolder folder;
  const std::string nowhere = folder.file("missing/a.txt");
  EXPECT_EQ(message_of(nowhere), nowhere + ": cannot be written: the folder " +
                                     folder.file("missing") + " does not exist");
  EXPECT_EQ(message_of(folder.file("")), folder.file("") + ": cannot be written: it is a folder");
  EXPECT_EQ(message_of(""), "output path: is empty");
  // A full disk is only noticed while writing: nothing may be left of it. /dev/full stands for one.
  EXPECT_EQ(message_of("/dev/full"), "/dev/full: cannot be written: No space left on device");
}

}  // namespace
}  // namespace ovoid::io
