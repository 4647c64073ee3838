// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace ovoid::io {

// 0 to 63; -1 for what is no digit of base64 [RFC 4648].
int value_of_base64_digit(char c) noexcept;

// The bytes that the digits stand for, up to the first other character. With blanks, line ends and
// padding between them, as MIME breaks lines and as pieces that were encoded apart follow each
// other: these are passed over, and behind padding a new piece begins.
std::string decoded_base64(std::string_view text);

// In one line, with padding.
std::string encoded_base64(std::string_view bytes);

}  // namespace ovoid::io
