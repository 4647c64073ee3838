// SPDX-License-Identifier: Apache-2.0
#include "console.h"

#include <fcntl.h>
#include <unistd.h>

#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <system_error>

#include "interrupt.h"
#include "ovoid/error.h"
#include "usage.h"

namespace ovoid::cli {
namespace {

[[noreturn]] void throw_cannot_write_out() {
  throw Error(ErrorCode::kFileWrite,
              fmt::format("standard output: cannot be written: {}", std::strerror(errno)));
}

}  // namespace

void hold_standard_files() noexcept {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(descriptor, F_GETFD) >= 0 || errno != EBADF) continue;
    // The lowest that is free, which is this one.
    open("/dev/null", descriptor == STDERR_FILENO ? O_WRONLY : O_RDONLY);
  }
}

void write_out(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size()) throw_cannot_write_out();
}

void flush_out() {
  if (std::fflush(stdout) != 0) throw_cannot_write_out();
}

void tell(std::string_view text) noexcept {
  while (!text.empty()) {
    const ssize_t written = ::write(STDERR_FILENO, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

int complain(std::string_view message, int exit_code) noexcept {
  try {
    tell(fmt::format("ovoid: error: {}\n", message_line(std::string(message))));
  } catch (const std::bad_alloc&) {
    tell("ovoid: error: out of memory\n");
  }
  return exit_code;
}

Failure failure_of_exception() {
  try {
    throw;
  } catch (const UsageError& error) {
    return {error.what(), kExitUsage};
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kCancelled) return {error.what(), Interrupt::exit_code()};
    const bool is_memory = error.code() == ErrorCode::kOutOfMemory;
    return {error.what(), is_memory ? kExitOutOfMemory : kExitFailed};
  } catch (const std::bad_alloc&) {
    return {"out of memory", kExitOutOfMemory};
  } catch (const std::system_error& error) {
    if (error.code() != std::errc::resource_unavailable_try_again)
      return {std::string("unexpected: ") + error.what(), kExitFailed};
    return {"a thread cannot be made: the system grants no more (ulimit -u, ulimit -v)",
            kExitFailed};
  } catch (const std::exception& error) {
    return {std::string("unexpected: ") + error.what(), kExitFailed};
  }
}

int complain_of_exception() noexcept {
  try {
    const Failure failure = failure_of_exception();
    return complain(failure.message, failure.exit_code);
  } catch (const std::bad_alloc&) {
    return complain("out of memory", kExitOutOfMemory);
  }
}

std::string one_line(const std::string& text) {
  std::string line = text;
  for (char& c : line) {
    if (std::iscntrl(static_cast<unsigned char>(c)) != 0) c = '?';
  }
  return line;
}

std::string message_line(const std::string& text) {
  constexpr std::string_view kGap = " ... ";
  constexpr std::size_t kTail = kMaxMessageSize / 4;
  if (text.size() <= kMaxMessageSize) return one_line(text);
  // Between characters of UTF-8.
  const auto is_inside = [&](std::size_t at) {
    return (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80U;
  };
  std::size_t head = kMaxMessageSize - kTail - kGap.size();
  std::size_t tail = text.size() - kTail;
  while (head > 0 && is_inside(head)) --head;
  while (tail < text.size() && is_inside(tail)) ++tail;
  return one_line(fmt::format("{}{}{}", text.substr(0, head), kGap, text.substr(tail)));
}

}  // namespace ovoid::cli
