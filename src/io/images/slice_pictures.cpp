// SPDX-License-Identifier: Apache-2.0
#include "io/images/slice_pictures.h"

#include <fmt/format.h>

#include <array>

#include "io/core/samples.h"
#include "io/images/tiff.h"
#include "ovoid/error.h"

namespace ovoid::io {

std::optional<SliceReader> slice_reader(std::string_view format) noexcept {
  if (format == "PNG") return png_slices();
  if (format == "JPEG") return jpeg_slices();
  if (format == "TIFF") return tiff_slices();
  return std::nullopt;
}

void check_slice_size(const ByteSource& source, const SliceShape& shape) {
  constexpr std::int64_t kMostBytesOfOne = 8 * 2731;
  const std::array sizes{shape.width, shape.height};
  const std::int64_t num_bytes =
      checked_num_bytes(source.name() + ": size", sizes, shape.type, shape.num_components);
  if (num_bytes / kMostBytesOfOne <= source.size()) return;
  throw Error(ErrorCode::kFileFormat,
              fmt::format("{}: has {} bytes, too few for a picture of {} x {} pixels",
                          source.name(), source.size(), shape.width, shape.height));
}

}  // namespace ovoid::io
