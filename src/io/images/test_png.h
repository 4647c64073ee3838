// SPDX-License-Identifier: Apache-2.0
// PNG files of any kind, made here: for tests of readers, and where fuzzing starts from.
#pragma once

#include <zlib.h>

#include <cstdint>
#include <string>

#include "io/core/test_deflate.h"

namespace ovoid::io {

inline std::string png_number(std::uint32_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift);
  return bytes;
}

inline std::string png_chunk(const std::string& name, const std::string& content) {
  const std::string body = name + content;
  const auto sum =
      ::crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()));
  return png_number(static_cast<std::uint32_t>(content.size())) + body +
         png_number(static_cast<std::uint32_t>(sum));
}

// What PNG numbers the kinds of pixels by.
enum class PngPixels : char { kGrey = 0, kRgb = 2, kPalette = 3, kGreyAlpha = 4, kRgba = 6 };

struct TestPng {
  std::uint32_t width = 0, height = 0;
  char bits = 8;
  PngPixels pixels = PngPixels::kGrey;
  std::string palette{};  // red, green, blue, ...
};

// `rows`: the pixels, 16 bits big endian; of as many bytes in a row as in all others.
inline std::string png_file(const TestPng& png, const std::string& rows) {
  std::string filtered;
  const std::size_t row_size = rows.size() / png.height;
  for (std::size_t at = 0; at < rows.size(); at += row_size)
    filtered += '\0' + rows.substr(at, row_size);
  std::string head = png_number(png.width) + png_number(png.height);
  head += {png.bits, static_cast<char>(png.pixels), 0, 0, 0};
  std::string file = "\x89PNG\r\n\x1a\n" + png_chunk("IHDR", head);
  if (!png.palette.empty()) file += png_chunk("PLTE", png.palette);
  return file + png_chunk("IDAT", deflated(filtered, 15)) + png_chunk("IEND", "");
}

}  // namespace ovoid::io
