// SPDX-License-Identifier: Apache-2.0
// Other programs that are run: found on PATH, started without a shell.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace ovoid::cli {

// The first file of that name on PATH that can be run; empty: none.
std::string find_program(const std::string& name);

struct ChildFiles {
  int out = -1;     // a descriptor that becomes standard output; -1: /dev/null
  std::string err;  // a file that takes standard error, written anew; empty: /dev/null
};

// Starts the program with these words, the first of them its own name. Standard input is empty, and
// the signals that this program keeps to itself or ignores are as they usually are. The caller
// waits for it (waitpid). Throws Error(kUnsupported) with the system's reason.
pid_t start_program(const std::string& program, const std::vector<std::string>& words,
                    const ChildFiles& files);

}  // namespace ovoid::cli
