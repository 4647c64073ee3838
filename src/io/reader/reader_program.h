// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace ovoid::io {

// The program ovoid-read that belongs to this library: `named`, unless that is empty; else beside
// the program or shared library that this code is in, or in ../libexec/ovoid or
// ../../libexec/ovoid from there; else where it was to be installed. Throws Error(kUnsupported)
// that says where it was looked for.
std::string find_reader_program(const std::string& named);

}  // namespace ovoid::io
