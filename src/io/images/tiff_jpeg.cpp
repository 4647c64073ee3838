// SPDX-License-Identifier: Apache-2.0
#include "io/images/tiff_jpeg.h"

#include <fmt/format.h>

#include "io/core/memory.h"
#include "io/images/jpeg_reading.h"

namespace ovoid::io {
namespace {

std::string libjpeg_says(const char* part, const JpegReading& reading) {
  return fmt::format("{}cannot be read: libjpeg: {}", part, reading.message());
}

}  // namespace

std::string unpack_tiff_jpeg(const TiffJpegBlock& block, std::span<const std::byte> packed,
                             std::span<std::byte> out) {
  JpegReading reading;
  if (!block.tables.empty() && !reading.read_tables(block.tables))
    return libjpeg_says("has tables (JPEGTables) that ", reading);
  // The TIFF says what the components are; its pictures often have no markers of their own.
  const JpegColours colours = block.is_ycbcr ? JpegColours::kFromYcbcr : JpegColours::kAsStored;
  if (!reading.begin(packed, colours)) return libjpeg_says("", reading);
  const std::int64_t row_size = block.width * block.num_samples;
  const std::int64_t num_rows = static_cast<std::int64_t>(out.size()) / row_size;
  // The last strip may be short in the TIFF and whole in its JPEG.
  if (reading.width() != block.width || reading.height() < num_rows ||
      reading.height() > block.height || reading.num_components() != block.num_samples) {
    return fmt::format("is a JPEG of {} x {} pixels of {} components: expected {} x {} of {}",
                       reading.width(), reading.height(), reading.num_components(), block.width,
                       num_rows, block.num_samples);
  }
  require_memory("a strip or tile", reading.num_coefficient_bytes());
  if (!reading.read_rows(out)) return libjpeg_says("", reading);
  return {};
}

}  // namespace ovoid::io
