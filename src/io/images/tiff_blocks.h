// SPDX-License-Identifier: Apache-2.0
// Strips and tiles of TIFF, unpacked.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "io/images/tiff_file.h"

namespace ovoid::io {

// TIFF's numbers for the compressions that are read.
inline constexpr int kTiffPlain = 1, kTiffLzw = 5, kTiffJpeg = 7, kTiffDeflate = 8,
                     kTiffPackBits = 32773, kTiffOldDeflate = 32946, kTiffZstandard = 50000;

// "JPEG" and so on; the number for an unknown one.
std::string tiff_compression_name(int compression);

bool is_read_compression(int compression) noexcept;

// How many bytes one of such data stands for at most. Deflate: see kMaxDeflateRatio. LZW: 12 bits
// for 4096 bytes, at best. PackBits: two for 128. Zstandard: three, of a block, for 128 KiB. JPEG:
// 10 blocks of a bit or more for 32 x 32 pixels of 4 components, so 3277.
std::int64_t max_tiff_ratio(int compression) noexcept;

// Fills `out` from packed bytes, of any compression but JPEG. Empty if all is well, else what is
// wrong.
std::string unpack_tiff(int compression, std::span<const std::byte> packed,
                        std::span<std::byte> out);

// How the samples of a row lie in a block.
struct TiffRows {
  std::size_t row_size = 0;    // bytes
  std::size_t num_in_row = 0;  // samples
  int num_samples = 1;         // of a pixel
  int bits = 8;
  bool is_big_endian = false;
};

// Undoes TIFF's predictor (2: differences of integers, 3: of the bytes of floats) and gives samples
// of whole bytes the native byte order. `bytes`: whole rows.
void finish_tiff_rows(int predictor, const TiffRows& rows, std::span<std::byte> bytes);

// Samples of fewer bits than their type, first bits first, as 8 or 16 bits; `most`: what they are
// stretched to, or 0.
void spread_tiff_bits(std::span<const std::byte> row, int bits, unsigned most,
                      std::span<std::byte> out);

}  // namespace ovoid::io
