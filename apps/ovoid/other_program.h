// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace ovoid::cli {

// The path of a program that is installed beside this one, and whether it is.
struct OtherProgram {
  std::string path;
  bool is_there;
};
OtherProgram program_beside(const std::string& name);

// Becomes the program, with these words after its name. Throws Error(kUnsupported) with the
// system's reason; `what` begins its message.
[[noreturn]] void become(const std::string& program, const std::vector<std::string>& words,
                         const std::string& what);

}  // namespace ovoid::cli
