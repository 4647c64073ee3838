// SPDX-License-Identifier: Apache-2.0
#include "priority.h"

#ifdef __linux__
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>
#endif

namespace ovoid::viewer {

void lower_priority([[maybe_unused]] int nicer) noexcept {
#ifdef __linux__
  const auto thread = static_cast<id_t>(syscall(SYS_gettid));  // Linux nices threads, not processes
  setpriority(PRIO_PROCESS, thread, getpriority(PRIO_PROCESS, thread) + nicer);
#endif
}

}  // namespace ovoid::viewer
