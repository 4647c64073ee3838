// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace ovoid::io {

// The content of a small text file or pipe, read by pieces; nothing beyond `max_bytes` is read.
// Throws Error: kFileNotFound for what is missing, a folder or unreadable; kFileFormat for more
// bytes.
std::string read_text(const std::string& path, std::size_t max_bytes);

// Throws Error(kFileFormat) for more bytes, as read_text() does.
void require_size(std::string_view text, std::size_t max_bytes, const std::string& path);

// The number that the whole text is, if it is finite; a plus sign may stand before it.
std::optional<double> parse_real(std::string_view text) noexcept;

}  // namespace ovoid::io
