// SPDX-License-Identifier: Apache-2.0
#include "priority.h"

#ifdef __linux__
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>
#endif

namespace ovoid::viewer {

void lower_priority() noexcept {
#ifdef __linux__
  constexpr int kNicer = 6;  // a quarter of the time, where another thread wants the same processor
  const auto thread = static_cast<id_t>(syscall(SYS_gettid));  // Linux nices threads, not processes
  setpriority(PRIO_PROCESS, thread, getpriority(PRIO_PROCESS, thread) + kNicer);
#endif
}

}  // namespace ovoid::viewer
