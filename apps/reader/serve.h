// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/reader/reader_link.h"

namespace ovoid::reader {

// The whole life of a reader process: takes requests from the socket, enters the sandbox with the
// first, answers each, and ends the process when the other end is closed. Does not return.
[[noreturn]] void serve_requests(io::UniqueFd socket);

}  // namespace ovoid::reader
