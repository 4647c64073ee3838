// SPDX-License-Identifier: Apache-2.0
// A thread waits for the signals instead of a handler: request_stop() takes locks and runs
// callbacks, which no signal handler may.
#include "interrupt.h"

#include <unistd.h>

#include <array>
#include <ctime>
#include <string_view>
#include <system_error>

#include "ovoid/io.h"
#include "usage.h"

namespace ovoid::cli {
namespace {

constexpr std::array kSignals = {SIGINT, SIGTERM, SIGHUP};
constexpr int kOurs = SIGUSR1;  // to end the waiter

std::atomic<int> signal_that_came{0};
std::atomic<bool> is_silent{false};
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<bool>::is_always_lock_free);

// Async-signal-safe.
[[noreturn]] void end_at_once() noexcept {
  remove_partial_files();
  constexpr std::string_view kClear = "\r\x1b[K";  // the line of the progress
  constexpr std::string_view kLine = "ovoid: error: interrupted\n";
  ssize_t ignored = 0;
  if (is_silent) _exit(Interrupt::exit_code());
  if (isatty(STDERR_FILENO) == 1) ignored = ::write(STDERR_FILENO, kClear.data(), kClear.size());
  ignored = ::write(STDERR_FILENO, kLine.data(), kLine.size());
  static_cast<void>(ignored);
  _exit(Interrupt::exit_code());
}

void on_signal(int signal) {
  signal_that_came = signal;
  end_at_once();
}

void set_handler(int signal, void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  sigemptyset(&action.sa_mask);
  sigaction(signal, &action, nullptr);
}

}  // namespace

void Interrupt::be_silent() noexcept { is_silent = true; }

int Interrupt::exit_code() noexcept {
  constexpr int kBase = 128;
  const int signal = signal_that_came;
  return signal == 0 ? kExitInterrupted : kBase + signal;
}

Interrupt::Interrupt(std::chrono::milliseconds grace) : grace_(grace) {
  set_handler(SIGPIPE, SIG_IGN);
  set_handler(SIGXFSZ, SIG_IGN);
  sigemptyset(&signals_);
  // A signal that the parent had ignored (a shell's background job, nohup) stays ignored.
  for (const int signal : kSignals) {
    struct sigaction action {};
    sigaction(signal, nullptr, &action);
    if (action.sa_handler != SIG_IGN) sigaddset(&signals_, signal);
  }
  sigset_t blocked = signals_;
  sigaddset(&blocked, kOurs);
  pthread_sigmask(SIG_BLOCK, &blocked, nullptr);
  try {
    waiter_ = std::thread([this] { wait(); });
  } catch (const std::system_error&) {
    // No thread is to be had: then a handler ends the program, which cannot ask anybody.
    for (const int signal : kSignals) {
      if (sigismember(&signals_, signal) == 1) set_handler(signal, on_signal);
    }
    pthread_sigmask(SIG_UNBLOCK, &blocked, nullptr);
  }
}

Interrupt::~Interrupt() {
  if (!waiter_.joinable()) return;
  // The waiter is ending the program.
  if (is_over_.exchange(true)) {
    while (true) pause();
  }
  pthread_kill(waiter_.native_handle(), kOurs);
  waiter_.join();
}

void Interrupt::wait() {
  sigset_t all = signals_;
  sigaddset(&all, kOurs);
  while (!is_over_) {
    int signal = 0;
    if (sigwait(&all, &signal) != 0 || signal == kOurs) continue;
    signal_that_came = signal;
    source_.request_stop();
    wait_for_the_end();
  }
}

void Interrupt::wait_for_the_end() {
  using Clock = std::chrono::steady_clock;
  sigset_t all = signals_;
  sigaddset(&all, kOurs);
  const auto end = Clock::now() + grace_;
  while (!is_over_) {
    const auto left = std::chrono::nanoseconds(end - Clock::now()).count();
    constexpr std::int64_t kSecond = 1'000'000'000;
    const std::int64_t wait = left > 0 ? left : 0;
    const timespec timeout{static_cast<time_t>(wait / kSecond), static_cast<long>(wait % kSecond)};
    const int signal = sigtimedwait(&all, nullptr, &timeout);
    const bool is_too_long = signal < 0 && Clock::now() >= end;
    const bool is_second = signal > 0 && signal != kOurs;
    if ((is_too_long || is_second) && !is_over_.exchange(true)) end_at_once();
  }
}

}  // namespace ovoid::cli
