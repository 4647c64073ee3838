// SPDX-License-Identifier: Apache-2.0
// A thread waits for the signals instead of a handler: request_stop() takes locks and runs
// callbacks, which no signal handler may.
#include "interrupt.h"

#include <unistd.h>

#include "usage.h"

namespace ovoid::cli {

Interrupt::Interrupt() {
  sigemptyset(&signals_);
  // A signal that the parent had ignored (a shell's background job) stays ignored.
  for (const int signal : {SIGINT, SIGTERM}) {
    struct sigaction action {};
    sigaction(signal, nullptr, &action);
    if (action.sa_handler != SIG_IGN) sigaddset(&signals_, signal);
  }
  sigaddset(&signals_, SIGUSR1);  // our own, to end the waiter
  pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
  waiter_ = std::thread([this] { wait(); });
}

Interrupt::~Interrupt() {
  is_over_ = true;
  pthread_kill(waiter_.native_handle(), SIGUSR1);
  waiter_.join();
}

void Interrupt::wait() {
  while (true) {
    int signal = 0;
    if (sigwait(&signals_, &signal) != 0) continue;
    if (signal == SIGUSR1) {
      if (is_over_) return;
      continue;
    }
    if (source_.stop_requested()) _exit(kExitInterrupted);
    source_.request_stop();
  }
}

}  // namespace ovoid::cli
