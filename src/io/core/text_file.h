// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

namespace ovoid::io {

// As read_text_file() has it (ovoid/io.h).
std::string read_text(const std::string& path, std::size_t max_bytes);

// Throws Error(kFileFormat) for more bytes, as read_text() does.
void require_size(std::size_t num_bytes, std::size_t max_bytes, const std::string& path);

}  // namespace ovoid::io
