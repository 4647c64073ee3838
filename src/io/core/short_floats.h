// SPDX-License-Identifier: Apache-2.0
// Floats of 16 bits, as networks, cameras and compressed files hold them, become float32, which
// holds each of them exactly. Readers read their bits as uint16 and widen what they have read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "ovoid/dataset.h"

namespace ovoid::io {

enum class ShortFloat : std::uint8_t {
  kNone,   // no such float
  kHalf,   // 5 bits of exponent, 10 of fraction: binary16 of IEEE 754
  kBrain,  // 8 and 7: the upper half of a float32 ("bfloat16")
};

const char* name_of(ShortFloat kind) noexcept;  // "float16", "bfloat16"; empty for kNone

// Of what a file stores, for messages: samples of `type`, or short floats whose bits those are.
const char* stored_name(ScalarType type, ShortFloat kind) noexcept;

// The number that 16 bits stand for; NaN keeps its sign and what of it fits.
float float_of(std::uint16_t bits, ShortFloat kind) noexcept;

// The bits of the nearest number, of two the one that ends in 0; what is too large is infinite.
std::uint16_t bits_of(float value, ShortFloat kind) noexcept;

// As many floats, native byte order, at `to` as `bits` has; the two do not overlap.
void widen(std::span<const std::byte> bits, ShortFloat kind, std::byte* to) noexcept;

// The array of uint16, which may stay in its file, becomes one of float32 with the numbers that its
// bits stand for; of kNone nothing happens. Throws Error(kOutOfMemory).
void widen_short_floats(ShortFloat kind, DataArray& array);

}  // namespace ovoid::io
