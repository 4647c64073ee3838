// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <string>

#include "io/core/memory.h"
#include "io/images/jpeg_reading.h"
#include "io/images/slice_pictures.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

[[noreturn]] void refuse_jpeg(const ByteSource& source, const JpegReading& reading) {
  throw Error(ErrorCode::kFileFormat,
              fmt::format("{}: cannot be read: libjpeg: {}", source.name(), reading.message()));
}

// `bytes` must outlive the reading. False if they are no whole header.
bool begin_jpeg(JpegReading& reading, const std::string& bytes) {
  return reading.begin(std::as_bytes(std::span(bytes)), JpegColours::kByItsMarkers);
}

SliceShape begun_shape(const JpegReading& reading) {
  SliceShape shape;
  shape.width = reading.width();
  shape.height = reading.height();
  shape.num_components = reading.num_components();
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
  require_memory(source.name(), found.num_bytes() + reading.num_coefficient_bytes());
  if (!reading.read_rows(out)) refuse_jpeg(source, reading);
}

}  // namespace

SliceReader jpeg_slices() noexcept { return {"JPEG", shape_of_jpeg, read_jpeg_slice}; }

}  // namespace ovoid::io
