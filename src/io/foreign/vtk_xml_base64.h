// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "io/core/byte_source.h"

namespace ovoid::io {

// VTK 9.1 goes to places within base64 by counting digits, and leaves what lies behind a line end
// as memory happens to be. A copy of the file whose arrays are as VTK writes them: in one line,
// size and numbers encoded together, or apart where they are compressed. Empty if the file has no
// base64. The offsets of appended arrays may count line ends or not. Takes twice the file's size in
// memory. Throws Error(kOutOfMemory), and for tags that cannot be read.
std::optional<std::string> with_plain_base64(const ByteSource& source);

}  // namespace ovoid::io
