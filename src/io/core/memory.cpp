// SPDX-License-Identifier: Apache-2.0
#include "io/core/memory.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <limits>
#include <string_view>

#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kUnknown = std::numeric_limits<std::int64_t>::max();

std::atomic<std::int64_t> told_memory = kUnknown;

// MemAvailable counts what the system would free for us, such as cached files.
std::int64_t free_in_machine() {
  std::ifstream file("/proc/meminfo");
  std::string key, unit;
  std::int64_t kibibytes = 0, sum = 0;
  bool is_known = false;
  while (file >> key >> kibibytes) {
    std::getline(file, unit);
    const bool is_free = key == "MemAvailable:";
    if (is_free || key == "SwapFree:") sum += kibibytes * 1024;
    is_known = is_known || is_free;
  }
  return is_known ? sum : kUnknown;
}

// All of it: what is taken already is partly cached files, which go when memory is wanted.
std::int64_t limit_of_container() {
  for (const char* const path :
       {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"}) {
    std::ifstream file(path);
    std::int64_t bytes = 0;
    if (file >> bytes && bytes > 0) return bytes;
  }
  return kUnknown;
}

std::int64_t left_of_address_space() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kUnknown;
  std::ifstream file("/proc/self/statm");
  std::int64_t pages = 0;
  file >> pages;
  const std::int64_t taken = pages * sysconf(_SC_PAGESIZE);
  return std::max<std::int64_t>(static_cast<std::int64_t>(limit.rlim_cur) - taken, 0);
}

std::string size_text(std::int64_t num_bytes) {
  return fmt::format("{:.1f} MiB", static_cast<double>(num_bytes) / (1 << 20));
}

}  // namespace

void set_available_memory(std::int64_t num_bytes) { told_memory = num_bytes; }

std::int64_t available_memory() {
  if (const std::int64_t told = told_memory; told != kUnknown) return told;
  return std::min({free_in_machine(), limit_of_container(), left_of_address_space()});
}

void require_memory(const std::string& what, std::int64_t num_bytes) {
  // Looking costs more than a small array.
  constexpr std::int64_t kSmall = std::int64_t{16} << 20;
  if (num_bytes <= kSmall) return;
  const std::int64_t available = available_memory();
  if (num_bytes <= available) return;
  throw Error(ErrorCode::kOutOfMemory, fmt::format("{}: takes {} of memory, {} are free", what,
                                                   size_text(num_bytes), size_text(available)));
}

}  // namespace ovoid::io
