// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace ovoid::io {

// The program that reads a format: "ovoid-read", or "ovoid-read-vdb" for OpenVDB, whose library
// takes so long to load that others shall not wait for it.
std::string_view reader_program_of(std::string_view format);

// The program of that name that belongs to this library: `named`, unless that is empty, or, if
// `named` is ovoid-read and another is wanted, the one beside it; else beside the program or shared
// library that this code is in, or in ../libexec/ovoid or ../../libexec/ovoid from there; else
// where it was to be installed, or where the distribution's package has it. Throws
// Error(kUnsupported) that says where it was looked for, to read `source`.
std::string find_reader_program(const std::string& source, const std::string& named,
                                std::string_view program = "ovoid-read");

// The variables that the program is started with, "NAME=value": of LD_LIBRARY_PATH the absolute
// folders, where a cluster may keep its libraries; and what makes the system's library give out
// memory with nothing left in it of what lay there (apps/reader/unwritten.h). Nothing else. An
// empty or a relative entry would be the folder that the host works in, which may be that of the
// data. `library_path`: LD_LIBRARY_PATH of the host, or null.
std::vector<std::string> reader_environment(const char* library_path);

}  // namespace ovoid::io
