// SPDX-License-Identifier: Apache-2.0
#include "io/core/base64.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace ovoid::io {
namespace {

constexpr std::string_view kDigits =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

constexpr std::array<std::int8_t, 256> values_of_characters() {
  std::array<std::int8_t, 256> values{};
  values.fill(-1);
  for (std::size_t i = 0; i < kDigits.size(); ++i)
    values[static_cast<unsigned char>(kDigits[i])] = static_cast<std::int8_t>(i);
  return values;
}
constexpr std::array<std::int8_t, 256> kValues = values_of_characters();

constexpr char kBase64Padding = '=';

}  // namespace

int value_of_base64_digit(char c) noexcept { return kValues[static_cast<unsigned char>(c)]; }

std::string decoded_base64(std::string_view text) {
  std::string bytes;
  bytes.reserve(text.size() / 4 * 3);
  std::uint32_t bits = 0;
  unsigned num_bits = 0;
  for (const char c : text) {
    const int value = value_of_base64_digit(c);
    if (value < 0) {
      if (c == kBase64Padding) num_bits = 0;
      if (c == kBase64Padding || c == ' ' || c == '\t' || c == '\n' || c == '\r') continue;
      break;
    }
    bits = (bits << 6U | static_cast<std::uint32_t>(value)) & 0xffffU;
    num_bits += 6;
    if (num_bits < 8) continue;
    num_bits -= 8;
    bytes += static_cast<char>(bits >> num_bits & 0xffU);
  }
  return bytes;
}

std::string encoded_base64(std::string_view bytes) {
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::string_view group = bytes.substr(i, 3);
    std::uint32_t bits = 0;
    for (std::size_t j = 0; j < 3; ++j)
      bits = bits << 8U | (j < group.size() ? static_cast<unsigned char>(group[j]) : 0U);
    for (unsigned j = 0; j < 4; ++j)
      text += j > group.size() ? kBase64Padding : kDigits[bits >> (18 - 6 * j) & 0x3fU];
  }
  return text;
}

}  // namespace ovoid::io
