// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace ovoid::io {

// Bytes that this process may still take, as far as the system says: of the machine's free memory
// and swap, the container's limit (cgroup) and the process's own (RLIMIT_AS), the least. Cost:
// three small files of /proc and /sys.
std::int64_t available_memory();

// What available_memory() returns from now on: for a process that may not look at the system, and
// whose host has looked.
void set_available_memory(std::int64_t num_bytes);

// Throws Error(kOutOfMemory) naming `what`, which needs `num_bytes`, if these are more than there
// are: a header may declare what a small packed file unpacks to, and no machine has.
void require_memory(const std::string& what, std::int64_t num_bytes);

}  // namespace ovoid::io
