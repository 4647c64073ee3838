// SPDX-License-Identifier: Apache-2.0
#include "io/foreign/bitshuffle.h"

#include <algorithm>
#include <cstdint>

namespace ovoid::io {

void unshuffle_bits(std::span<const std::byte> block, std::size_t item_size,
                    std::span<std::byte> out) noexcept {
  const std::size_t num_items = block.size() / item_size, row = num_items / 8;
  std::fill(out.begin(), out.end(), std::byte{0});
  for (std::size_t b = 0; b < item_size; ++b) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      const std::byte* const bits = block.data() + (b * 8 + bit) * row;
      for (std::size_t eight = 0; eight < row; ++eight) {
        const auto packed = std::to_integer<unsigned>(bits[eight]);
        for (unsigned i = 0; i < 8; ++i)
          out[(eight * 8 + i) * item_size + b] |= std::byte((packed >> i & 1U) << bit);
      }
    }
  }
}

}  // namespace ovoid::io
