// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace ovoid::io {

// The program ovoid-read that belongs to this library: `named`, unless that is empty; else beside
// the program or shared library that this code is in, or in ../libexec/ovoid or
// ../../libexec/ovoid from there; else where it was to be installed, or where the distribution's
// package has it. Throws Error(kUnsupported) that says where it was looked for, to read `source`.
std::string find_reader_program(const std::string& source, const std::string& named);

}  // namespace ovoid::io
