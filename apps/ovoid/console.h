// SPDX-License-Identifier: Apache-2.0
// Standard output and standard error. What a command was asked for goes to the one and must get
// there; what is told besides goes to the other, and nothing depends on whether anybody hears it.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>

namespace ovoid::cli {

// To be called first: a standard file that the parent has closed would be the next one that is
// opened, and the picture would get the notes. A closed standard output stays one that refuses.
void hold_standard_files() noexcept;

// Throws Error(kFileWrite) with the system's reason.
void write_out(std::string_view text);
void flush_out();

template <typename... Values>
void print_out(fmt::format_string<Values...> format, Values&&... values) {
  write_out(fmt::format(format, std::forward<Values>(values)...));
}

// On standard error, at once.
void tell(std::string_view text) noexcept;

// The line of a failure; returns `exit_code`.
int complain(std::string_view message, int exit_code) noexcept;

// What the exception that is being handled comes to.
struct Failure {
  std::string message;
  int exit_code;
};
Failure failure_of_exception();

// Its line on standard error; returns its exit code.
int complain_of_exception() noexcept;

// Text as one printable line: control characters, which file names may hold, become '?'.
std::string one_line(const std::string& text);

// An error or a note as people are told it, wherever it was made: one printable line, of which a
// long one keeps its head, which names the thing, and its tail, which says what was expected.
// Damaged files may put anything between these.
inline constexpr std::size_t kMaxMessageSize = 980;  // with "ovoid: error: " at most 1,000 bytes
std::string message_line(const std::string& text);

}  // namespace ovoid::cli
