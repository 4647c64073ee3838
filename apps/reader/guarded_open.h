// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace ovoid::reader {

// From now on open(), openat(), fopen() and their kin refuse with EACCES, in all libraries of this
// process, whatever is neither one of these files nor below one of these folders (real paths), and
// every opening for writing. Calls that a library makes past these functions are not seen.
void guard_open(const std::vector<std::string>& files, const std::vector<std::string>& folders);

// The real path that was refused first since the last call; empty if none was. Not among them: what
// system libraries look for by themselves, below /sys, /usr and /etc/ld.so.
std::string take_refused_open();

}  // namespace ovoid::reader
