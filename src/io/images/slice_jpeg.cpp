// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <csetjmp>
#include <cstdio>  // jpeglib.h needs it first
#include <string>

#include <jpeglib.h>

#include "io/core/memory.h"
#include "io/images/slice_pictures.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// Neither C++ exceptions nor messages may cross libjpeg: the file is in memory, and errors jump.
struct JpegReading {
  jpeg_error_mgr errors{};  // first, so that a pointer to it is one to the whole
  jpeg_progress_mgr progress{};
  jpeg_decompress_struct jpeg{};
  jmp_buf jump{};
  char message[JMSG_LENGTH_MAX] = {};

  JpegReading() = default;
  ~JpegReading() { jpeg_destroy_decompress(&jpeg); }
  JpegReading(const JpegReading&) = delete;
  JpegReading& operator=(const JpegReading&) = delete;
};

[[noreturn]] void on_jpeg_read_error(j_common_ptr jpeg) {
  auto* reading = reinterpret_cast<JpegReading*>(jpeg->err);
  jpeg->err->format_message(jpeg, reading->message);
  std::longjmp(reading->jump, 1);
}

// A file that is cut short or damaged only makes libjpeg warn, and fill in grey.
void on_jpeg_warning(j_common_ptr jpeg, int level) {
  if (level < 0) on_jpeg_read_error(jpeg);
}

// Each scan of a progressive picture costs the work of the whole, in a few bytes of the file.
void limit_jpeg_scans(j_common_ptr jpeg) {
  constexpr int kMostScans = 200;
  if (reinterpret_cast<j_decompress_ptr>(jpeg)->input_scan_number <= kMostScans) return;
  auto* reading = reinterpret_cast<JpegReading*>(jpeg->err);
  std::snprintf(reading->message, sizeof(reading->message), "more than %d scans", kMostScans);
  std::longjmp(reading->jump, 1);
}

// Between setjmp and a longjmp: no object with a destructor lives in these two.
bool begin_jpeg(JpegReading* reading, const unsigned char* bytes, unsigned long num_bytes) {
  jpeg_decompress_struct& jpeg = reading->jpeg;
  jpeg.err = jpeg_std_error(&reading->errors);
  reading->errors.error_exit = on_jpeg_read_error;
  reading->errors.emit_message = on_jpeg_warning;
  if (setjmp(reading->jump) != 0) return false;
  jpeg_create_decompress(&jpeg);
  reading->progress.progress_monitor = limit_jpeg_scans;
  jpeg.progress = &reading->progress;
  jpeg_mem_src(&jpeg, bytes, num_bytes);
  jpeg_read_header(&jpeg, TRUE);
  jpeg.out_color_space = jpeg.num_components == 1 ? JCS_GRAYSCALE : JCS_RGB;
  jpeg.dct_method = JDCT_ISLOW;
  jpeg_calc_output_dimensions(&jpeg);
  return true;
}

bool read_jpeg_rows(JpegReading* reading, unsigned char* out, std::size_t row_size) {
  jpeg_decompress_struct& jpeg = reading->jpeg;
  if (setjmp(reading->jump) != 0) return false;
  jpeg_start_decompress(&jpeg);
  while (jpeg.output_scanline < jpeg.output_height) {
    JSAMPROW rows[] = {out + row_size * jpeg.output_scanline};
    jpeg_read_scanlines(&jpeg, rows, 1);
  }
  jpeg_finish_decompress(&jpeg);
  return true;
}

[[noreturn]] void refuse_jpeg(const ByteSource& source, const JpegReading& reading) {
  throw Error(ErrorCode::kFileFormat,
              fmt::format("{}: cannot be read: libjpeg: {}", source.name(), reading.message));
}

// `bytes` must outlive the reading. False if they are no whole header.
bool begin_jpeg(JpegReading& reading, const std::string& bytes) {
  return begin_jpeg(&reading, reinterpret_cast<const unsigned char*>(bytes.data()),
                    static_cast<unsigned long>(bytes.size()));
}

SliceShape begun_shape(const JpegReading& reading) {
  SliceShape shape;
  shape.width = reading.jpeg.output_width;
  shape.height = reading.jpeg.output_height;
  shape.num_components = reading.jpeg.output_components;
  return shape;
}

// Comments and pictures in miniature may stand before the size.
constexpr std::int64_t kJpegHeads[] = {std::int64_t{16} << 10, std::int64_t{16} << 20};

SliceShape shape_of_jpeg(const ByteSource& source) {
  for (const std::int64_t size : kJpegHeads) {
    const std::string bytes = source.text(0, size);
    JpegReading reading;
    if (begin_jpeg(reading, bytes)) return begun_shape(reading);
    if (size >= source.size() || size == kJpegHeads[1]) refuse_jpeg(source, reading);
  }
  return {};
}

void read_jpeg_slice(const ByteSource& source, const SliceShape& shape, std::span<std::byte> out) {
  const std::string bytes = source.text(0, source.size());
  JpegReading reading;
  if (!begin_jpeg(reading, bytes)) refuse_jpeg(source, reading);
  const SliceShape found = begun_shape(reading);
  if (found.width != shape.width || found.height != shape.height ||
      found.num_bytes() != static_cast<std::int64_t>(out.size()))
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: has changed", source.name()));
  // Progressive pictures are held as coefficients of 16 bits first.
  require_memory(source.name(), 3 * found.num_bytes());
  if (!read_jpeg_rows(&reading, reinterpret_cast<unsigned char*>(out.data()),
                      static_cast<std::size_t>(found.width * found.num_components)))
    refuse_jpeg(source, reading);
}

}  // namespace

SliceReader jpeg_slices() noexcept { return {"JPEG", shape_of_jpeg, read_jpeg_slice}; }

}  // namespace ovoid::io
