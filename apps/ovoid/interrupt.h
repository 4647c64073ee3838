// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <csignal>
#include <stop_token>
#include <thread>

namespace ovoid::cli {

// Ctrl-C, SIGTERM and SIGHUP as a stop token. To be made before any other thread, which then
// inherit that these signals are left to it. The first signal asks the work to stop. What has not
// stopped after `grace`, or at a second signal, is ended at once: partial files are removed, one
// line says so, and the exit code is exit_code().
//
// A pipe that nobody reads and a file that may not grow are errors of the write that meets them,
// not signals that end the program.
class Interrupt {
 public:
  explicit Interrupt(std::chrono::milliseconds grace);
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  std::stop_token token() const { return source_.get_token(); }

  // From now on no line says that the program was ended.
  static void be_silent() noexcept;

  // 128 + the signal that came, as shells report it; kExitInterrupted if none did.
  static int exit_code() noexcept;

 private:
  void wait();
  void wait_for_the_end();

  sigset_t signals_{};
  std::chrono::milliseconds grace_;
  std::stop_source source_;
  std::atomic<bool> is_over_{false};
  std::thread waiter_;
};

}  // namespace ovoid::cli
