// SPDX-License-Identifier: Apache-2.0
#include "io/core/memory.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <fstream>

#include "fuzz/seeds.h"
#include "io/images/test_volumes.h"
#include "io/read_source.h"

namespace ovoid::io {
namespace memory_test {

// The process may take `bytes` more while it lives.
class MemoryLimit {
 public:
  explicit MemoryLimit(std::int64_t bytes) {
    getrlimit(RLIMIT_AS, &before_);
    std::int64_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    rlimit limit = before_;
    limit.rlim_cur = static_cast<rlim_t>(pages * sysconf(_SC_PAGESIZE) + bytes);
    setrlimit(RLIMIT_AS, &limit);
  }
  ~MemoryLimit() { setrlimit(RLIMIT_AS, &before_); }
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;

 private:
  rlimit before_{};
};

constexpr std::int64_t kMiB = std::int64_t{1} << 20;

TEST(Memory, WhatIsNotThereIsRefusedByNameAndSize) {
  EXPECT_GT(available_memory(), 16 * kMiB);
  EXPECT_EQ(error_of([] {
              require_memory("a.nii: 2x2x2 uint8", std::int64_t{1} << 60);
            }).find("out-of-memory: a.nii: 2x2x2 uint8: takes 1099511627776.0 MiB of memory, "),
            0U);
  EXPECT_EQ(error_of([] { require_memory("a", 17 * kMiB); }), "");
}

// A packed file is small whatever it declares: the header is held against the memory before a byte
// is unpacked. Fails if it is unpacked until memory runs out.
TEST(Memory, PackedFilesAreHeldAgainstItBeforeTheyAreUnpacked) {
  const std::string header =
      "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 512 512 1024\nencoding: gzip\n\n";
  const std::string bytes = header + fuzz::gzip(std::string(256 * kMiB, '\0'));
  ASSERT_LT(bytes.size(), static_cast<std::size_t>(kMiB));
  const auto source = open_memory("a.nrrd", std::as_bytes(std::span(bytes)));
  double furthest = 0;
  ReadOptions options;
  options.progress = [&](double fraction) { furthest = std::max(furthest, fraction); };
  const MemoryLimit limit(100 * kMiB);
  EXPECT_EQ(error_of([&] {
              read_source(*source, options);
            }).find("out-of-memory: a.nrrd: 512x512x1024 uint8: takes 256.0 MiB of memory, "),
            0U);
  EXPECT_EQ(furthest, 0);
}

}  // namespace memory_test
}  // namespace ovoid::io
