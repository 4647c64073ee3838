// SPDX-License-Identifier: Apache-2.0
#include "io/images/jpeg_reading.h"

namespace ovoid::io {
namespace {

const unsigned char* jpeg_bytes(std::span<const std::byte> bytes) noexcept {
  return reinterpret_cast<const unsigned char*>(bytes.data());
}

}  // namespace

void JpegReading::on_error(j_common_ptr jpeg) {
  auto* reading = static_cast<JpegReading*>(jpeg->client_data);
  jpeg->err->format_message(jpeg, reading->message_);
  std::longjmp(reading->jump_, 1);
}

void JpegReading::on_message(j_common_ptr jpeg, int level) {
  if (level < 0) on_error(jpeg);
}

// Each scan of a progressive picture costs the work of the whole, in a few bytes of the file.
void JpegReading::limit_scans(j_common_ptr jpeg) {
  constexpr int kMostScans = 200;
  if (reinterpret_cast<j_decompress_ptr>(jpeg)->input_scan_number <= kMostScans) return;
  auto* reading = static_cast<JpegReading*>(jpeg->client_data);
  std::snprintf(reading->message_, sizeof(reading->message_), "more than %d scans", kMostScans);
  std::longjmp(reading->jump_, 1);
}

// Between setjmp and a longjmp, here and below: no object with a destructor lives.
void JpegReading::create() noexcept {
  if (jpeg_.mem != nullptr) return;
  jpeg_.err = jpeg_std_error(&errors_);
  errors_.error_exit = on_error;
  errors_.emit_message = on_message;
  jpeg_.client_data = this;  // libjpeg keeps this and `err`
  jpeg_create_decompress(&jpeg_);
  progress_.progress_monitor = limit_scans;
  jpeg_.progress = &progress_;
}

bool JpegReading::read_tables(std::span<const std::byte> bytes) noexcept {
  if (setjmp(jump_) != 0) return false;
  create();
  jpeg_mem_src(&jpeg_, jpeg_bytes(bytes), static_cast<unsigned long>(bytes.size()));
  if (jpeg_read_header(&jpeg_, FALSE) == JPEG_HEADER_TABLES_ONLY) return true;
  std::snprintf(message_, sizeof(message_), "a picture where tables are expected");
  return false;
}

bool JpegReading::begin(std::span<const std::byte> bytes, JpegColours colours) noexcept {
  if (setjmp(jump_) != 0) return false;
  create();
  jpeg_mem_src(&jpeg_, jpeg_bytes(bytes), static_cast<unsigned long>(bytes.size()));
  jpeg_read_header(&jpeg_, TRUE);
  if (colours == JpegColours::kFromYcbcr) jpeg_.jpeg_color_space = JCS_YCbCr;
  if (colours == JpegColours::kAsStored) {
    jpeg_.jpeg_color_space = jpeg_.out_color_space = JCS_UNKNOWN;
  } else {
    jpeg_.out_color_space = jpeg_.num_components == 1 ? JCS_GRAYSCALE : JCS_RGB;
  }
  jpeg_.dct_method = JDCT_ISLOW;
  jpeg_calc_output_dimensions(&jpeg_);
  return true;
}

std::int64_t JpegReading::num_coefficient_bytes() noexcept {
  if (jpeg_has_multiple_scans(&jpeg_) == FALSE) return 0;
  return width() * height() * jpeg_.num_components * static_cast<std::int64_t>(sizeof(JCOEF));
}

bool JpegReading::read_rows(std::span<std::byte> out) noexcept {
  const auto row_size = static_cast<std::size_t>(width() * num_components());
  const auto num_rows = static_cast<JDIMENSION>(out.size() / row_size);
  if (setjmp(jump_) != 0) return false;
  jpeg_start_decompress(&jpeg_);
  while (jpeg_.output_scanline < num_rows) {
    JSAMPROW rows[] = {reinterpret_cast<JSAMPROW>(out.data() + row_size * jpeg_.output_scanline)};
    jpeg_read_scanlines(&jpeg_, rows, 1);
  }
  if (num_rows == jpeg_.output_height) jpeg_finish_decompress(&jpeg_);
  return true;
}

}  // namespace ovoid::io
