// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

namespace ovoid::io {

// Undoes the transposition of bits of the filter "bitshuffle" [Masui 2015] in one block: of items
// of `item_size` bytes, as many as a multiple of eight, their first bits stand behind each other,
// then their second, from the lowest bit of the first byte on. `out` is as long as `block`, and
// apart.
void unshuffle_bits(std::span<const std::byte> block, std::size_t item_size,
                    std::span<std::byte> out) noexcept;

}  // namespace ovoid::io
