// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <new>
#include <string>

#include "io/core/atomic_file.h"
#include "io/core/signatures.h"
#include "io/images/npy.h"
#include "io/pictures/pictures.h"
#include "ovoid/encode.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid {
namespace {

enum class ImageFormat { kPng, kJpeg, kExr, kNpy };

ImageFormat image_format_of(const std::string& path) {
  const std::string ending = io::ending_of(path);
  if (ending == ".png") return ImageFormat::kPng;
  if (ending == ".jpg" || ending == ".jpeg") return ImageFormat::kJpeg;
  if (ending == ".exr") return ImageFormat::kExr;
  if (ending == ".npy") return ImageFormat::kNpy;
  throw Error(
      ErrorCode::kUnsupported,
      fmt::format("{}: the ending '{}' names no picture format: expected .png, .jpg, .exr or .npy",
                  path, ending));
}

void check_image(const Image& image) {
  if (image.width < 1 || image.height < 1) {
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("image: is {}x{}: expected at least one pixel", image.width, image.height));
  }
  const std::size_t num_pixels =
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  if (image.rgba.size() != 4 * num_pixels || image.depth.size() != num_pixels ||
      image.front_depth.size() != num_pixels) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("image: {}x{} has {} colour, {} depth and {} front depth values: "
                            "expected {}, {} and {}",
                            image.width, image.height, image.rgba.size(), image.depth.size(),
                            image.front_depth.size(), 4 * num_pixels, num_pixels, num_pixels));
  }
  if (!image.normals.empty() && image.normals.size() != 3 * num_pixels) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("image: {}x{} has {} values of normals: expected {}, or none",
                            image.width, image.height, image.normals.size(), 3 * num_pixels));
  }
}

}  // namespace

namespace io {

void write_picture_npy(const Image& image, const std::string& path, const std::stop_token& stop) {
  const std::array<std::int64_t, 3> shape{image.height, image.width, 4};
  AtomicFile file(path, stop);
  file.write(npy_header(ScalarType::kFloat32, shape));
  file.write(image.rgba.data(), image.rgba.size() * sizeof(float));
  file.commit();
}

}  // namespace io

void check_image_path(const std::string& path) {
  image_format_of(path);
  io::check_writable(path);
}

void write_image(const Image& image, const std::string& path, const std::optional<Rgb>& background,
                 const WriteOptions& options) try {
  const ImageFormat target = image_format_of(path);
  check_image(image);
  switch (target) {
    case ImageFormat::kPng:
      return io::write_png(to_rgba8(image, background), image.width, image.height, path,
                           options.stop);
    case ImageFormat::kJpeg:
      return io::write_jpeg(to_rgba8(image, background.value_or(Rgb{0, 0, 0})), image.width,
                            image.height, path, options.stop);
    case ImageFormat::kExr:
      return io::write_exr(image, path, options.stop);
    case ImageFormat::kNpy:
      return io::write_picture_npy(image, path, options.stop);
  }
} catch (const std::bad_alloc&) {
  throw Error(ErrorCode::kOutOfMemory, path + ": no memory to write it");
}

std::string encode_png(const Image& image, const std::optional<Rgb>& background) try {
  check_image(image);
  return io::png_bytes(to_rgba8(image, background), image.width, image.height, "picture");
} catch (const std::bad_alloc&) {
  throw Error(ErrorCode::kOutOfMemory, "picture: no memory to pack it");
}

std::string encode_jpeg(const Image& image, const Rgb& background, int quality) try {
  check_image(image);
  if (quality < 1 || quality > 100) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("quality = {}: expected a number from 1 to 100", quality));
  }
  return io::jpeg_bytes(to_rgba8(image, background), image.width, image.height, quality, "picture");
} catch (const std::bad_alloc&) {
  throw Error(ErrorCode::kOutOfMemory, "picture: no memory to pack it");
}

}  // namespace ovoid
