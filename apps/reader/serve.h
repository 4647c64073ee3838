// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/reader/reader_link.h"
#include "io/reader/reader_messages.h"
#include "ovoid/dataset.h"

namespace ovoid::reader {

// Reads in this process, which is in the sandbox. Throws Error.
using ReadHere = Dataset (*)(const io::ReaderRequest&);

// The whole life of a reader process: takes requests from the socket, descriptor 3, enters the
// sandbox with the first, answers each, and ends the process when the other end is closed. Returns
// the exit code of a program, called `name`, that was not started by the library.
int run_reader(const char* name, ReadHere read);

}  // namespace ovoid::reader
