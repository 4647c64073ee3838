// SPDX-License-Identifier: Apache-2.0
// Pictures as slices of a volume: their numbers, as they are stored.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "io/core/byte_source.h"
#include "io/core/short_floats.h"
#include "ovoid/lattice.h"

namespace ovoid::io {

// What a picture's header says.
struct SliceShape {
  std::int64_t width = 0, height = 0;
  ScalarType type = ScalarType::kUInt8;
  int num_components = 1;                      // 3: red, green, blue
  ShortFloat short_float = ShortFloat::kNone;  // whose bits are samples of `type`
  // Distance of pixels, where the file means a length in the world by it.
  std::optional<std::array<double, 2>> spacing{};
  std::string length_unit{};  // of the spacing

  std::int64_t num_bytes() const noexcept {
    return width * height * num_components * static_cast<std::int64_t>(size_of(type));
  }
};

// How one format's pictures are read. Both throw Error: kFileFormat naming the file, kUnsupported.
struct SliceReader {
  std::string_view format;  // as picture_format_of() calls it
  SliceShape (*shape)(const ByteSource& source) = nullptr;
  // Fills `out`, as long as the shape says, row by row, components interleaved, native byte order.
  void (*read)(const ByteSource& source, const SliceShape& shape,
               std::span<std::byte> out) = nullptr;
};

// Grey of fewer than 8 bits is stretched to 8, palettes become the colours that they stand for,
// transparency is passed over.
SliceReader png_slices() noexcept;
// Baseline and progressive, of 8 bits; grey or colour.
SliceReader jpeg_slices() noexcept;

// By picture_format_of(); none for a format whose pictures are not read.
std::optional<SliceReader> slice_reader(std::string_view format) noexcept;

// Throws Error(kFileFormat) if a file of this size cannot hold what its header says: a byte of
// TIFF's LZW stands for 2731 at most, of deflate's for fewer, and samples of one bit become eight.
void check_slice_size(const ByteSource& source, const SliceShape& shape);

}  // namespace ovoid::io
