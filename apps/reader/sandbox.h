// SPDX-License-Identifier: Apache-2.0
// What keeps a reader of other people's files to the files that it was given. Linux; three rings,
// so that one remains where a kernel lacks the others:
//   1. open() and fopen() are this program's own and refuse what was not given, by its real path;
//   2. Landlock (Linux 5.13): the kernel refuses the same, whoever asks;
//   3. seccomp: no sockets, no programs, no other processes, no writing.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace ovoid::reader {

// From now on this process opens these files, and those below these folders, for reading and
// nothing else; both are real paths. Cannot be undone. What the kernel has not is left out.
void enter_sandbox(const std::vector<std::string>& files, const std::vector<std::string>& folders);

// The file whose opening was refused first since the last call; empty if none was.
std::string take_refused_file();

}  // namespace ovoid::reader
