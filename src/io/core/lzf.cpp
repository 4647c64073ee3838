// SPDX-License-Identifier: Apache-2.0
#include "io/core/lzf.h"

#include <algorithm>
#include <cstdint>

namespace ovoid::io {
namespace {

// One instruction: bytes that follow it, or a copy of those `distance` before.
struct Instruction {
  std::size_t length = 0;    // of what it writes
  std::size_t distance = 0;  // 0: bytes that follow
};

// Takes the next one off the front; nothing if the data end within it.
std::optional<Instruction> next_instruction(std::span<const std::byte>& packed) noexcept {
  const auto byte = [&](std::size_t i) { return std::to_integer<std::size_t>(packed[i]); };
  const std::size_t control = byte(0);
  constexpr std::size_t kLongestRun = 32, kLongLength = 7;
  if (control < kLongestRun) {
    if (packed.size() < control + 2) return std::nullopt;
    packed = packed.subspan(1);
    return Instruction{control + 1, 0};
  }
  const bool is_long = control >> 5U == kLongLength;
  const std::size_t size = is_long ? 3 : 2;
  if (packed.size() < size) return std::nullopt;
  const Instruction copy{(control >> 5U) + (is_long ? byte(1) : 0) + 2,
                         ((control & 31U) << 8U) + byte(size - 1) + 1};
  packed = packed.subspan(size);
  return copy;
}

}  // namespace

std::optional<std::size_t> lzf_size(std::span<const std::byte> packed) noexcept {
  std::size_t size = 0;
  while (!packed.empty()) {
    const auto next = next_instruction(packed);
    if (!next || next->distance > size) return std::nullopt;
    size += next->length;
    if (next->distance == 0) packed = packed.subspan(next->length);
  }
  return size;
}

void unpack_lzf(std::span<const std::byte> packed, std::span<std::byte> out) noexcept {
  std::size_t at = 0;
  while (!packed.empty()) {
    const auto next = next_instruction(packed);
    if (!next || next->distance > at || next->length > out.size() - at) return;
    if (next->distance == 0) {
      std::copy_n(packed.begin(), next->length, out.begin() + static_cast<std::ptrdiff_t>(at));
      packed = packed.subspan(next->length);
    } else {
      // Byte by byte: a copy may reach into what it writes itself.
      for (std::size_t i = 0; i < next->length; ++i) out[at + i] = out[at + i - next->distance];
    }
    at += next->length;
  }
}

}  // namespace ovoid::io
