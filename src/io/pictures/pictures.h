// SPDX-License-Identifier: Apache-2.0
// One writer for each picture format; write_image chooses. All throw Error(kFileWrite) and write
// the same bytes for the same picture.
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "ovoid/image.h"

namespace ovoid::io {

// 8-bit RGBA, straight alpha, with the sRGB chunk. `rgba8`: [height, width, 4].
void write_png(std::span<const std::uint8_t> rgba8, int width, int height, const std::string& path,
               const std::stop_token& stop = {});

// 8-bit RGB of high quality, colour as fine as brightness; alpha is passed over.
void write_jpeg(std::span<const std::uint8_t> rgba8, int width, int height, const std::string& path,
                const std::stop_token& stop = {});

// What these two write, in memory; `name` stands in messages. Quality is in [1, 100].
std::string png_bytes(std::span<const std::uint8_t> rgba8, int width, int height,
                      const std::string& name);
std::string jpeg_bytes(std::span<const std::uint8_t> rgba8, int width, int height, int quality,
                       const std::string& name);

// 32-bit float channels R, G, B, A (premultiplied), Z (front depth), half_opacity.Z (depth) and, of
// pictures that have normals, N.X, N.Y, N.Z; ZIP-compressed scan lines. The names are those of
// [OpenEXR 2024], where Z is the front of what a pixel shows and layers stand before a dot.
void write_exr(const Image& image, const std::string& path, const std::stop_token& stop = {});

// float32 [height, width, 4], premultiplied.
void write_picture_npy(const Image& image, const std::string& path,
                       const std::stop_token& stop = {});

struct Rgba8Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgba;  // [height, width, 4], straight alpha
};

// Any PNG, as 8 bits. Throws Error(kFileFormat), also where there is no such file.
Rgba8Picture read_png(const std::string& path);

}  // namespace ovoid::io
