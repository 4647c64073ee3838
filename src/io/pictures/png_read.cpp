// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <png.h>

#include <memory>

#include "io/pictures/pictures.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

struct FreePng {
  void operator()(png_image* png) const noexcept { png_image_free(png); }
};

}  // namespace

Rgba8Picture read_png(const std::string& path) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  const std::unique_ptr<png_image, FreePng> frees(&png);
  const auto check = [&](int done) {
    if (done != 0) return;
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: cannot be read: libpng: {}", path, png.message));
  };
  check(png_image_begin_read_from_file(&png, path.c_str()));
  png.format = PNG_FORMAT_RGBA;
  Rgba8Picture picture;
  picture.width = static_cast<int>(png.width);
  picture.height = static_cast<int>(png.height);
  picture.rgba.resize(PNG_IMAGE_SIZE(png));
  check(png_image_finish_read(&png, nullptr, picture.rgba.data(), 0, nullptr));
  return picture;
}

}  // namespace ovoid::io
