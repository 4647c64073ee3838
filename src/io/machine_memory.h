// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace ovoid::io {

// Bytes that this process may take now without pushing others out: what Linux calls available, or
// what is left of the limit of a container, whichever is less; a guess of 8 GiB where neither can be
// found out.
std::uint64_t available_memory();

}  // namespace ovoid::io
