// SPDX-License-Identifier: Apache-2.0
#include "io/core/atomic_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include "io/core/test_folder.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "ovoid/output_files.h"

namespace ovoid::io {
namespace atomic_file_test {

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

// Fails if one of several files is there before the last is whole, or when that never is.
TEST(FilesTogether, AppearTogether) {
  const TestFolder folder;
  folder.write("a.txt", "old");
  {
    FilesTogether files;
    write_atomically(folder.file("a.txt"), "new");
    write_atomically(folder.file("b.txt"), "longer");
    EXPECT_EQ(folder.read("a.txt"), "old");
    EXPECT_FALSE(std::filesystem::exists(folder.file("b.txt")));
    EXPECT_EQ(size_of_written(folder.file("b.txt")), 6);
  }
  EXPECT_EQ(folder.read("a.txt"), "old");
  EXPECT_EQ(folder.count(), 1);
  FilesTogether files;
  write_atomically(folder.file("a.txt"), "new");
  write_atomically(folder.file("b.txt"), "longer");
  files.commit();
  EXPECT_EQ(folder.read("a.txt"), "new");
  EXPECT_EQ(folder.read("b.txt"), "longer");
  EXPECT_EQ(folder.count(), 2);
}

// The last of three cannot be put in its place: those before it are taken back.
TEST(FilesTogether, AreTakenBackTogether) {
  const TestFolder folder;
  folder.write("a.txt", "old");
  {
    FilesTogether files;
    for (const char* const name : {"a.txt", "b.txt", "c.txt"})
      write_atomically(folder.file(name), "new");
    std::filesystem::create_directory(folder.file("c.txt"));
    EXPECT_THROW(files.commit(), Error);
  }
  EXPECT_EQ(folder.read("a.txt"), "old");
  EXPECT_EQ(folder.count(), 2);  // and the folder
}

// A signal that ends the program takes those with it that are whole and have no name yet.
TEST(FilesTogether, AreKnownToTheSignalHandler) {
  const TestFolder folder;
  FilesTogether files;
  write_atomically(folder.file("a.txt"), "new");
  EXPECT_EQ(folder.count(), 1);
  remove_partial_files();
  EXPECT_EQ(folder.count(), 0);
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

TEST(AtomicFile, PartialNamesCannotBeKnownBefore) {
  const TestFolder folder;
  std::set<std::string> names;
  for (int i = 0; i < 10; ++i) {
    const AtomicFile file(folder.file("a.txt"));
    const std::filesystem::path partial = file.partial_path();
    EXPECT_EQ(partial.parent_path(), std::filesystem::path(folder.file("a.txt")).parent_path());
    EXPECT_EQ(partial.filename().string().find(std::to_string(::getpid())), std::string::npos);
    names.insert(partial.string());
  }
  EXPECT_EQ(names.size(), 10U);
}

mode_t mode_of(const std::string& path) {
  struct stat info {};
  EXPECT_EQ(::stat(path.c_str(), &info), 0) << path;
  return info.st_mode & 07777;
}

// Data of patients must not become everybody's, neither afterwards nor on the way.
TEST(AtomicFile, KeepsTheModeOfWhatIsReplaced) {
  const TestFolder folder;
  for (const mode_t mode : {0600, 0640, 0664, 0444}) {
    const std::string path = folder.write("a.txt", "old");
    ASSERT_EQ(::chmod(path.c_str(), mode), 0);
    AtomicFile file(path);
    EXPECT_EQ(mode_of(file.partial_path()), 0600U);
    file.write("new");
    file.commit();
    EXPECT_EQ(mode_of(path), mode);
    EXPECT_EQ(folder.read("a.txt"), "new");
    ::unlink(path.c_str());
  }
}

TEST(AtomicFile, KeepsTheOwnerOfWhatIsReplaced) {
  if (::geteuid() != 0) GTEST_SKIP() << "only the superuser gives files away";
  const TestFolder folder;
  const std::string path = folder.write("a.txt", "old");
  ASSERT_EQ(::chown(path.c_str(), 1234, 4321), 0);
  write_atomically(path, "new");
  struct stat info {};
  ASSERT_EQ(::stat(path.c_str(), &info), 0);
  EXPECT_EQ(info.st_uid, 1234U);
  EXPECT_EQ(info.st_gid, 4321U);
}

// An access list that holds less than the mode says, kept; and none that the folder would add.
TEST(AtomicFile, KeepsTheAccessListOfWhatIsReplaced) {
  const TestFolder folder;
  const std::string path = folder.write("a.txt", "old");
  constexpr const char* kName = "system.posix_acl_access";
  // Version 2: the owner rw, user 1234 r, the group nothing, mask r, others nothing.
  const std::vector<std::uint32_t> words = {2,   0x00060001, ~0U, 0x00040002, 1234, 0x00000004,
                                            ~0U, 0x00040010, ~0U, 0x00000020, ~0U};
  if (::setxattr(path.c_str(), kName, words.data(), words.size() * 4, 0) != 0)
    GTEST_SKIP() << "the file system has no access lists";
  write_atomically(path, "new");
  std::vector<std::uint32_t> kept(words.size());
  EXPECT_EQ(::getxattr(path.c_str(), kName, kept.data(), kept.size() * 4),
            static_cast<ssize_t>(words.size() * 4));
  EXPECT_EQ(kept, words);
}

TEST(AtomicFile, NamesMayBeAsLongAsTheSystemTakes) {
  const TestFolder folder;
  const std::string longest(255, 'n');
  write_atomically(folder.file(longest), "x");
  EXPECT_EQ(folder.read(longest), "x");
  EXPECT_EQ(folder.count(), 1);
  const std::string too_long = folder.file(longest + 'n');
  EXPECT_EQ(message_of(too_long), too_long + ": cannot be written: File name too long");
  EXPECT_THROW(check_writable(too_long), Error);
}

TEST(AtomicFile, FollowsLinksToWhatIsNotThereYet) {
  const TestFolder folder;
  std::filesystem::create_symlink("second", folder.file("first"));
  std::filesystem::create_symlink("file", folder.file("second"));
  write_atomically(folder.file("first"), "new");
  EXPECT_EQ(folder.read("file"), "new");
  EXPECT_TRUE(std::filesystem::is_symlink(folder.file("first")));
  EXPECT_TRUE(std::filesystem::is_symlink(folder.file("second")));
}

TEST(AtomicFile, LinksThatLeadNowhereAreNotReplaced) {
  const TestFolder folder;
  const std::string a = folder.file("a"), b = folder.file("b");
  std::filesystem::create_symlink(a, b);
  std::filesystem::create_symlink(b, a);
  EXPECT_EQ(message_of(a), a + ": cannot be written: Too many levels of symbolic links");
  EXPECT_TRUE(std::filesystem::is_symlink(a));
}

TEST(AtomicFile, StopsBetweenPieces) {
  const TestFolder folder;
  folder.write("a.txt", "old");
  std::stop_source source;
  {
    AtomicFile file(folder.file("a.txt"), source.get_token());
    file.write("half");
    source.request_stop();
    EXPECT_THROW(file.write("of it"), Error);
    EXPECT_THROW(file.commit(), Error);
  }
  EXPECT_EQ(folder.read("a.txt"), "old");
  EXPECT_EQ(folder.count(), 1);
}

TEST(AtomicFile, ANewNameReplacesNothing) {
  const TestFolder folder;
  folder.write("theirs", "theirs");
  AtomicFile file(folder.file("a"));
  file.write("mine");
  EXPECT_THROW(file.commit_as(folder.file("theirs")), Error);
  EXPECT_EQ(folder.read("theirs"), "theirs");
  EXPECT_EQ(folder.count(), 1);
}

TEST(ReplaceFile, KeepsTheModeAndLeavesTheSourceWhereItFails) {
  const TestFolder folder;
  const std::string from = folder.write("from", "new");
  const std::string to = folder.write("to", "old");
  ASSERT_EQ(::chmod(to.c_str(), 0600), 0);
  EXPECT_THROW(replace_file(from, folder.file("nowhere/to")), Error);
  EXPECT_EQ(folder.read("from"), "new");
  replace_file(from, to);
  EXPECT_EQ(folder.read("to"), "new");
  EXPECT_EQ(mode_of(to), 0600U);
  EXPECT_EQ(folder.count(), 1);
}

TEST(ReplaceFile, CopiesToAnotherFileSystem) {
  if (!std::filesystem::is_directory("/dev/shm")) GTEST_SKIP() << "there is no other file system";
  const TestFolder folder;
  const std::string elsewhere = "/dev/shm/ovoid_replace_" + std::to_string(::getpid());
  const std::string bytes(3'000'000, 'x');
  const std::string from = folder.write("from", bytes);
  std::filesystem::create_symlink(elsewhere, folder.file("to"));
  replace_file(from, folder.file("to"));
  EXPECT_EQ(folder.read("to"), bytes);
  EXPECT_TRUE(std::filesystem::is_symlink(folder.file("to")));
  EXPECT_EQ(folder.count(), 1);
  ::unlink(elsewhere.c_str());
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

}  // namespace atomic_file_test
}  // namespace ovoid::io
