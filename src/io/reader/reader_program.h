// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace ovoid::io {

// The program ovoid-read that belongs to this library: what $OVOID_READER names; else beside the
// program or shared library that this code is in, or in ../libexec/ovoid from there; else where it
// was to be installed. Throws Error(kUnsupported) that says where it was looked for.
std::string find_reader_program();

}  // namespace ovoid::io
