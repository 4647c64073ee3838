// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

namespace ovoid::cli {

inline constexpr int kExitDone = 0;
inline constexpr int kExitFailed = 1;         // the work could not be done
inline constexpr int kExitUsage = 2;          // the command line cannot be right
inline constexpr int kExitOutOfMemory = 3;    // the memory was not enough
inline constexpr int kExitInterrupted = 130;  // 128 + SIGINT, as shells report it

// A command line that cannot be right, whatever the files hold: kExitUsage. The message names the
// flag, its value and what was expected, in one line.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace ovoid::cli
