// SPDX-License-Identifier: Apache-2.0
// Strips and tiles of TIFF that are pictures in JPEG [TIFF JPEG 1995].
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace ovoid::io {

// What the TIFF says of a strip or tile.
struct TiffJpegBlock {
  std::span<const std::byte> tables;  // that all blocks of a page share; none if empty
  std::int64_t width = 0;
  std::int64_t height = 0;  // of the block; the rows that are wanted may be fewer
  int num_samples = 1;      // of a pixel
  bool is_ycbcr = false;    // to become red, green and blue
};

// Fills `out` with the block's first rows, of width * num_samples bytes. Empty if all is well, else
// what is wrong.
std::string unpack_tiff_jpeg(const TiffJpegBlock& block, std::span<const std::byte> packed,
                             std::span<std::byte> out);

}  // namespace ovoid::io
