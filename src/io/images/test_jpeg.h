// SPDX-License-Identifier: Apache-2.0
// Pictures in JPEG made here: for tests, and where fuzzing starts from.
#pragma once

#include <cstdint>
#include <cstdio>  // jpeglib.h needs it first
#include <cstdlib>
#include <string>

#include <jpeglib.h>

namespace ovoid::io {

struct TestJpeg {
  std::uint32_t width = 8, height = 8;
  int num_components = 1;
  bool is_ycbcr = false;   // red, green and blue kept so, with half the colours along x and y
  bool has_tables = true;  // of its own
  bool is_progressive = false;
  int quality = 100;

  std::size_t row_size() const {
    return std::size_t{width} * static_cast<std::size_t>(num_components);
  }
};

// A writer to memory. libjpeg ends the process where a test asks for what it cannot do.
class TestJpegWriter {
 public:
  explicit TestJpegWriter(const TestJpeg& jpeg) {
    jpeg_.err = jpeg_std_error(&errors_);
    jpeg_create_compress(&jpeg_);
    jpeg_mem_dest(&jpeg_, &bytes_, &num_bytes_);
    jpeg_.image_width = jpeg.width;
    jpeg_.image_height = jpeg.height;
    jpeg_.input_components = jpeg.num_components;
    jpeg_.in_color_space = jpeg.is_ycbcr ? JCS_RGB : JCS_UNKNOWN;
    jpeg_set_defaults(&jpeg_);
    jpeg_set_quality(&jpeg_, jpeg.quality, TRUE);
    jpeg_.write_JFIF_header = FALSE;
    jpeg_.write_Adobe_marker = FALSE;
    if (jpeg.is_progressive) jpeg_simple_progression(&jpeg_);
  }
  ~TestJpegWriter() {
    jpeg_destroy_compress(&jpeg_);
    std::free(bytes_);  // libjpeg's own malloc()
  }
  TestJpegWriter(const TestJpegWriter&) = delete;
  TestJpegWriter& operator=(const TestJpegWriter&) = delete;

  jpeg_compress_struct* jpeg() { return &jpeg_; }
  std::string bytes() const { return {reinterpret_cast<const char*>(bytes_), num_bytes_}; }

 private:
  jpeg_error_mgr errors_{};
  jpeg_compress_struct jpeg_{};
  unsigned char* bytes_ = nullptr;
  unsigned long num_bytes_ = 0;
};

// `pixels`: rows from the top, components interleaved.
inline std::string jpeg_picture(const TestJpeg& jpeg, std::string pixels) {
  TestJpegWriter writer(jpeg);
  if (!jpeg.has_tables) jpeg_suppress_tables(writer.jpeg(), TRUE);
  jpeg_start_compress(writer.jpeg(), jpeg.has_tables ? TRUE : FALSE);
  for (std::uint32_t y = 0; y < jpeg.height; ++y) {
    JSAMPROW rows[] = {reinterpret_cast<JSAMPROW>(&pixels[y * jpeg.row_size()])};
    jpeg_write_scanlines(writer.jpeg(), rows, 1);
  }
  jpeg_finish_compress(writer.jpeg());
  return writer.bytes();
}

// The tables that such pictures lack.
inline std::string jpeg_tables(const TestJpeg& jpeg) {
  TestJpegWriter writer(jpeg);
  jpeg_write_tables(writer.jpeg());
  return writer.bytes();
}

}  // namespace ovoid::io
