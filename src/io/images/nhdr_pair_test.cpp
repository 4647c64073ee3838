// SPDX-License-Identifier: Apache-2.0
// An NHDR and its samples are replaced as one. Every call that changes a folder is a place at which
// the program may be killed, or at which the call may fail: each is tried. Fails if a header can
// name samples of another.
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "io/core/test_data.h"
#include "io/core/test_folder.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace nhdr_pair {

enum class Fate { kNone, kFail, kKillBefore, kKillAfter };
inline Fate fate = Fate::kNone;
inline int calls_left = 0;  // before it comes
inline bool has_come = false;

template <typename Call>
int with_fate(Call call) {
  if (fate == Fate::kNone || --calls_left >= 0) return call();
  if (has_come) return call();
  has_come = true;
  if (fate == Fate::kFail) {
    errno = EIO;
    return -1;
  }
  if (fate == Fate::kKillAfter) call();
  _exit(0);
}

template <typename Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace nhdr_pair

// In the place of the system's, for the whole program.
extern "C" {
int rename(const char* from, const char* to) noexcept {
  return nhdr_pair::with_fate(
      [&] { return nhdr_pair::next<int(const char*, const char*)>("rename")(from, to); });
}
int link(const char* from, const char* to) noexcept {
  return nhdr_pair::with_fate(
      [&] { return nhdr_pair::next<int(const char*, const char*)>("link")(from, to); });
}
int unlink(const char* path) noexcept {
  return nhdr_pair::with_fate([&] { return nhdr_pair::next<int(const char*)>("unlink")(path); });
}
}

namespace ovoid::io {
namespace nhdr_pair_test {

using nhdr_pair::Fate, nhdr_pair::fate, nhdr_pair::calls_left, nhdr_pair::has_come;

// Another size for each value, so that samples of another header cannot be read.
Dataset volume(std::uint8_t value) {
  Dataset dataset;
  dataset.lattice.dims = {4, 3, value};
  std::vector<std::byte> bytes(12U * value, std::byte{value});
  const auto tuples = static_cast<std::int64_t>(bytes.size());
  dataset.arrays.push_back(
      {"a", ScalarType::kUInt8, 1, tuples, "", false, own_bytes(std::move(bytes))});
  return dataset;
}

// The value of the samples that the header names, of the header's size; 0: there is no header.
int value_in(const std::string& path) {
  if (!std::filesystem::exists(path)) return 0;
  const Dataset read = read_dataset({path});
  const int size = static_cast<int>(read.lattice.dims[2]);
  for (const std::byte sample : read.arrays[0].bytes.view)
    EXPECT_EQ(std::to_integer<int>(sample), size) << path;
  return size;
}

// Writes 5 over what is there, in a process to which this happens at that call; false if it came to
// its end first. Its own message of an error is of no interest.
bool write_with(Fate what, int call, const std::string& path) {
  const pid_t child = fork();
  if (child == 0) {
    fate = what;
    calls_left = call;
    try {
      write_dataset(volume(5), path);
    } catch (const Error&) {
      _exit(has_come ? 0 : 2);
    }
    _exit(has_come ? 0 : 1);
  }
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) < 2) << status;
  return WEXITSTATUS(status) == 0;
}

class NhdrPair : public testing::TestWithParam<Fate> {};

TEST_P(NhdrPair, IsOldOrNewWhateverHappens) {
  int num_calls = 0;
  for (bool goes_on = true; goes_on; ++num_calls) {
    SCOPED_TRACE(num_calls);
    ASSERT_LT(num_calls, 50);
    const TestFolder folder;
    const std::string path = folder.file("a.nhdr");
    write_dataset(volume(3), path);
    ASSERT_EQ(folder.count(), 2);
    goes_on = write_with(GetParam(), num_calls, path);
    const int value = value_in(path);
    EXPECT_TRUE(value == 3 || value == 5) << value;
    if (!goes_on) {
      EXPECT_EQ(value, 5);
      EXPECT_EQ(folder.count(), 2);
    }
    // Whatever is left, the next one gets through, with the usual names, if they are free.
    const std::string raw = folder.file("a.raw");
    if (!std::filesystem::exists(raw) ||
        std::filesystem::equivalent(files_read_for(path).back(), raw)) {
      write_dataset(volume(7), path);
      EXPECT_EQ(value_in(path), 7);
      EXPECT_EQ(files_read_for(path).back(), raw);
    }
  }
  EXPECT_GE(num_calls, 4) << "the calls are not seen";
}

TEST_P(NhdrPair, IsWholeOrNothingWhereNoneWas) {
  for (int call = 0;; ++call) {
    SCOPED_TRACE(call);
    const TestFolder folder;
    const std::string path = folder.file("a.nhdr");
    const bool goes_on = write_with(GetParam(), call, path);
    const int value = value_in(path);
    EXPECT_TRUE(value == 0 || value == 5) << value;
    if (GetParam() == Fate::kFail && value == 0) EXPECT_EQ(folder.count(), 0);
    if (!goes_on) break;
  }
}

INSTANTIATE_TEST_SUITE_P(Fates, NhdrPair,
                         testing::Values(Fate::kFail, Fate::kKillBefore, Fate::kKillAfter));

TEST(NhdrPair, SamplesKeepTheirMode) {
  const TestFolder folder;
  const std::string path = folder.file("a.nhdr"), raw = folder.file("a.raw");
  write_dataset(volume(3), path);
  std::filesystem::permissions(raw, std::filesystem::perms(0600));
  write_dataset(volume(5), path);
  EXPECT_EQ(std::filesystem::status(raw).permissions(), std::filesystem::perms(0600));
}

TEST(NhdrPair, SamplesThatAreALinkAreRefused) {
  const TestFolder folder;
  const std::string path = folder.file("a.nhdr");
  write_dataset(volume(3), path);
  std::filesystem::rename(folder.file("a.raw"), folder.file("b.raw"));
  std::filesystem::create_symlink("b.raw", folder.file("a.raw"));
  try {
    write_dataset(volume(5), path);
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kFileWrite);
    EXPECT_NE(std::string(error.what()).find("symbolic link"), std::string::npos) << error.what();
  }
  EXPECT_EQ(value_in(path), 3);
}

}  // namespace nhdr_pair_test
}  // namespace ovoid::io
