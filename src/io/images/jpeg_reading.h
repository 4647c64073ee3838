// SPDX-License-Identifier: Apache-2.0
// Pictures in JPEG, read from memory by libjpeg. Neither C++ exceptions nor messages cross libjpeg:
// members return false where it finds something wrong, and message() says what.
#pragma once

#include <csetjmp>
#include <cstddef>
#include <cstdint>
#include <cstdio>  // jpeglib.h needs it first
#include <span>

#include <jpeglib.h>

namespace ovoid::io {

// What the components of a picture are turned into.
enum class JpegColours {
  kByItsMarkers,  // grey, or red, green and blue, by what the picture says of itself
  kFromYcbcr,     // red, green and blue, whatever it says
  kAsStored,      // no others than it stores
};

// One picture. Damage that libjpeg warns of, where it fills in grey, is an error here.
class JpegReading {
 public:
  JpegReading() = default;
  ~JpegReading() { jpeg_destroy_decompress(&jpeg_); }
  JpegReading(const JpegReading&) = delete;
  JpegReading& operator=(const JpegReading&) = delete;

  // Takes the tables of a stream without a picture, for a picture that has none of its own.
  bool read_tables(std::span<const std::byte> bytes) noexcept;

  // Reads a picture's header; `bytes` must outlive the reading.
  bool begin(std::span<const std::byte> bytes, JpegColours colours) noexcept;

  // After begin(): of the picture as read_rows() gives it.
  std::int64_t width() const noexcept { return jpeg_.output_width; }
  std::int64_t height() const noexcept { return jpeg_.output_height; }
  int num_components() const noexcept { return jpeg_.output_components; }
  // Bytes that libjpeg takes beside rows: the coefficients of a picture of several scans.
  std::int64_t num_coefficient_bytes() noexcept;

  // Fills `out` with as many whole rows as it holds, from the top, 8 bits for each component.
  bool read_rows(std::span<std::byte> out) noexcept;

  const char* message() const noexcept { return message_; }

 private:
  void create() noexcept;
  [[noreturn]] static void on_error(j_common_ptr jpeg);
  static void on_message(j_common_ptr jpeg, int level);
  static void limit_scans(j_common_ptr jpeg);

  jpeg_error_mgr errors_{};
  jpeg_progress_mgr progress_{};
  jpeg_decompress_struct jpeg_{};
  jmp_buf jump_{};
  char message_[JMSG_LENGTH_MAX] = {};
};

}  // namespace ovoid::io
