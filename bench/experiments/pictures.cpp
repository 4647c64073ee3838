// SPDX-License-Identifier: Apache-2.0
#include "experiments/pictures.h"

#include <algorithm>
#include <limits>

#include "ovoid/io.h"

namespace ovoid::experiments {

namespace {

constexpr int kGap = 8;

float* pixel_at(Image& image, int x, int y) {
  return image.rgba.data() + 4 * (y * image.width + x);
}

const float* pixel_at(const Image& image, int x, int y) {
  return image.rgba.data() + 4 * (y * image.width + x);
}

}  // namespace

Image blank(int width, int height) {
  Image image;
  image.width = width;
  image.height = height;
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  image.rgba.assign(4 * pixels, 0.0F);
  image.depth.assign(pixels, std::numeric_limits<float>::infinity());
  image.front_depth = image.depth;
  return image;
}

Image side_by_side(const std::vector<Image>& images) {
  int width = -kGap;
  int height = 0;
  for (const Image& image : images) {
    width += image.width + kGap;
    height = std::max(height, image.height);
  }
  Image result = blank(width, height);
  int left = 0;
  for (const Image& image : images) {
    for (int y = 0; y < image.height; ++y) {
      std::copy_n(pixel_at(image, 0, y), 4 * image.width, pixel_at(result, left, y));
    }
    left += image.width + kGap;
  }
  return result;
}

Image magnified(const Image& image, int x, int y, int side, int factor) {
  Image result = blank(side * factor, side * factor);
  for (int row = 0; row < result.height; ++row) {
    for (int column = 0; column < result.width; ++column) {
      std::copy_n(pixel_at(image, x + column / factor, y + row / factor), 4,
                  pixel_at(result, column, row));
    }
  }
  return result;
}

Image stretched(const Image& image, double gain) {
  double sum = 0;
  for (std::size_t n = 0; n < image.rgba.size(); n += 4) sum += static_cast<double>(image.rgba[n]);
  const double mean = 4 * sum / static_cast<double>(image.rgba.size());
  Image result = image;
  for (std::size_t n = 0; n < image.rgba.size(); ++n) {
    if (n % 4 == 3) continue;
    const double value = 0.5 + gain * (static_cast<double>(image.rgba[n]) - mean);
    result.rgba[n] = static_cast<float>(std::clamp(value, 0.0, 1.0));
  }
  return result;
}

void write_figure(const Image& image, const std::string& path) {
  constexpr Rgb kWhite{1, 1, 1};
  write_image(image, path, kWhite);
}

}  // namespace ovoid::experiments
