// SPDX-License-Identifier: Apache-2.0
#include "io/machine_memory.h"

#include <algorithm>
#include <fstream>
#include <optional>
#include <string>

namespace ovoid::io {
namespace {

// The number in a file of one number; nothing for another, "max" for one.
std::optional<std::uint64_t> number_in(const char* path) {
  std::ifstream file(path);
  std::uint64_t value = 0;
  if (!(file >> value)) return std::nullopt;
  return value;
}

std::optional<std::uint64_t> available_on_machine() {
  std::ifstream file("/proc/meminfo");
  std::string word;
  while (file >> word) {
    std::uint64_t kilobytes = 0;
    if (word == "MemAvailable:" && file >> kilobytes) return kilobytes * 1024;
  }
  return std::nullopt;
}

std::optional<std::uint64_t> left_in_container() {
  auto limit = number_in("/sys/fs/cgroup/memory.max");
  auto used = number_in("/sys/fs/cgroup/memory.current");
  if (!limit) {
    limit = number_in("/sys/fs/cgroup/memory/memory.limit_in_bytes");
    used = number_in("/sys/fs/cgroup/memory/memory.usage_in_bytes");
  }
  if (!limit || !used) return std::nullopt;
  return *limit - std::min(*limit, *used);
}

}  // namespace

std::uint64_t available_memory() {
  constexpr std::uint64_t kGuess = std::uint64_t{8} << 30;
  const std::uint64_t machine = available_on_machine().value_or(kGuess);
  return std::min(machine, left_in_container().value_or(machine));
}

}  // namespace ovoid::io
