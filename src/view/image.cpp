// SPDX-License-Identifier: Apache-2.0
#include "ovoid/image.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <limits>

#include "data/out_of_memory.h"
#include "ovoid/error.h"

namespace ovoid {
namespace {

// Round half up; what is not a number becomes 0 (every comparison with it is false).
std::uint8_t to_byte(double v) {
  if (!(v > 0.0)) return 0;
  return v >= 1.0 ? 255 : static_cast<std::uint8_t>(std::floor(v * 255.0 + 0.5));
}

std::size_t num_pixels(const Image& image) {
  return static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
}

void require_rgba(const Image& image, const char* name) {
  if (image.width >= 0 && image.height >= 0 && image.rgba.size() == 4 * num_pixels(image)) return;
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("{}.rgba has {} values: must have {} x {} x 4", name, image.rgba.size(),
                          image.height, image.width));
}

}  // namespace

std::vector<std::uint8_t> to_rgba8(const Image& image, const std::optional<Rgb>& background) {
  require_rgba(image, "image");
  const std::size_t size = image.rgba.size();
  auto bytes =
      data::allocated("the picture's bytes", size, [&] { return std::vector<std::uint8_t>(size); });
  for (std::size_t i = 0; i < bytes.size(); i += 4) {
    const double alpha = image.rgba[i + 3];
    for (std::size_t c = 0; c < 3; ++c) {
      const double premultiplied = image.rgba[i + c];
      const double value = background    ? premultiplied + (1.0 - alpha) * (*background)[c]
                           : alpha > 0.0 ? premultiplied / alpha
                                         : 0.0;
      bytes[i + c] = to_byte(value);
    }
    bytes[i + 3] = background ? std::uint8_t{255} : to_byte(alpha);
  }
  return bytes;
}

double psnr(const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("b is {} x {} pixels: must be {} x {} as a", b.width, b.height, a.width,
                            a.height));
  }
  require_rgba(a, "a");
  require_rgba(b, "b");
  double squares = 0.0;
  std::size_t covered = 0;
  for (std::size_t i = 0; i < a.rgba.size(); i += 4) {
    // Written so that a NaN opacity counts as covered and shows in the result.
    if (a.rgba[i + 3] <= 0.0F && b.rgba[i + 3] <= 0.0F) continue;
    ++covered;
    for (std::size_t c = 0; c < 4; ++c) {
      const double difference = static_cast<double>(a.rgba[i + c]) - b.rgba[i + c];
      squares += difference * difference;
    }
  }
  if (squares == 0.0) return std::numeric_limits<double>::infinity();
  return -10.0 * std::log10(squares / (4.0 * static_cast<double>(covered)));
}

}  // namespace ovoid
