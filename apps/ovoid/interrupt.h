// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <csignal>
#include <stop_token>
#include <thread>

namespace ovoid::cli {

// Ctrl-C (and SIGTERM) as a stop token. To be made before any other thread, which then inherit that
// these signals are left to it. The first signal asks the work to stop; a second one ends the
// program at once, for work that does not listen.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  std::stop_token token() const { return source_.get_token(); }

 private:
  void wait();

  sigset_t signals_{};
  std::stop_source source_;
  std::atomic<bool> is_over_{false};
  std::thread waiter_;
};

}  // namespace ovoid::cli
