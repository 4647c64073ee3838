// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/warp.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace ovoid::cpu {
namespace {

constexpr int kStripRows = 16;
constexpr int kReach = 2;  // of the filter, in units of its width

// [Mitchell 1988], B = C = 1/3; t >= 0.
float weight(float t) {
  return t < 1   ? (7.0F / 6 * t - 2) * t * t + 8.0F / 9
         : t < 2 ? ((-7.0F / 18 * t + 2) * t - 10.0F / 3) * t + 16.0F / 9
                 : 0.0F;
}

// The samples of one row or column of the base plane that a pixel takes, cut off at its ends. The
// weights of all that it would take add up to 1.
struct Taps {
  int first = 0, last = 0;     // [first, last)
  std::vector<float> weights;  // from `first` on
};

void set_taps(double at, float width, int size, Taps& taps) {
  const auto first = static_cast<int>(std::ceil(at - kReach * static_cast<double>(width)));
  const auto last = static_cast<int>(std::floor(at + kReach * static_cast<double>(width)));
  taps.first = std::clamp(first, 0, size);
  taps.last = std::clamp(last + 1, taps.first, size);
  taps.weights.clear();
  float total = 0;
  for (int i = first; i <= last; ++i) {
    const float w = weight(std::abs(static_cast<float>(i - at)) / width);
    total += w;
    if (i >= taps.first && i < taps.last) taps.weights.push_back(w);
  }
  for (float& w : taps.weights) w /= total;
}

using Rgba = std::array<float, 4>;

Rgba filtered(const view::BasePlane& base, const Image& samples, const Taps& x, const Taps& y) {
  Rgba sum{};
  for (int j = y.first; j < y.last; ++j) {
    const float* from =
        samples.rgba.data() + 4 * (static_cast<std::size_t>(j) * base.width + x.first);
    Rgba row{};
    for (int i = 0; i < x.last - x.first; ++i, from += 4) {
      for (std::size_t c = 0; c < 4; ++c)
        row[c] += x.weights[static_cast<std::size_t>(i)] * from[c];
    }
    const float weight = y.weights[static_cast<std::size_t>(j - y.first)];
    for (std::size_t c = 0; c < 4; ++c) sum[c] += weight * row[c];
  }
  return sum;
}

// How many samples wide a pixel is along both axes of the base plane, at least one.
std::array<float, 2> width_of_pixel(const view::BasePlane& base, const Eigen::Vector2d& at) {
  const Mat3& map = base.picture_from_base.matrix;
  const Vec3 pixel = map * Vec3(at[0], at[1], 1);
  const Eigen::Vector2d place = pixel.head<2>() / pixel[2];
  std::array<float, 2> width{};
  for (int a = 0; a < 2; ++a) {
    const Eigen::Vector2d per_sample = (map.col(a).head<2>() - place * map(2, a)) / pixel[2];
    width[static_cast<std::size_t>(a)] = std::max(static_cast<float>(1 / per_sample.norm()), 1.0F);
  }
  return width;
}

}  // namespace

bool is_seen(const view::BasePlane& base, const TileRect& tile) {
  Eigen::AlignedBox2d box;
  for (const double x : {tile.x0 - kReach - 1, tile.x1 + kReach}) {
    for (const double y : {tile.y0 - kReach - 1, tile.y1 + kReach}) {
      if (!base.is_parallel && (base.picture_from_base.matrix * Vec3(x, y, 1))[2] <= 0) return true;
      box.extend(base.picture_from_base(x, y));
    }
  }
  return box.max()[0] >= 0 && box.max()[1] >= 0 && box.min()[0] <= base.picture_width - 1 &&
         box.min()[1] <= base.picture_height - 1;
}

std::vector<TileRect> strips_of(const RenderOptions& options) {
  std::vector<TileRect> strips;
  for (int y = 0; y < options.height; y += kStripRows)
    strips.push_back({0, y, options.width, std::min(y + kStripRows, options.height)});
  return strips;
}

void warp(const view::BasePlane& base, const Image& samples, bool is_bounded, const TileRect& strip,
          Image& picture) {
  Taps taps_x;
  Taps taps_y;
  for (int y = strip.y0; y < strip.y1; ++y) {
    for (int x = strip.x0; x < strip.x1; ++x) {
      const Eigen::Vector2d at = base.base_from_picture(x, y);
      const auto [width_x, width_y] = width_of_pixel(base, at);
      if (!(at[0] > -2.0 * width_x && at[1] > -2.0 * width_y &&
            at[0] < base.width + 2.0 * width_x && at[1] < base.height + 2.0 * width_y))
        continue;
      set_taps(at[0], width_x, base.width, taps_x);
      set_taps(at[1], width_y, base.height, taps_y);
      const Rgba color = filtered(base, samples, taps_x, taps_y);
      const std::size_t pixel = static_cast<std::size_t>(y) * picture.width + x;
      for (std::size_t c = 0; c < 4; ++c)
        picture.rgba[4 * pixel + c] = is_bounded ? std::clamp(color[c], 0.0F, 1.0F) : color[c];
      const auto i = static_cast<int>(std::round(at[0]));
      const auto j = static_cast<int>(std::round(at[1]));
      if (i < 0 || j < 0 || i >= base.width || j >= base.height) continue;
      const float z = samples.depth[static_cast<std::size_t>(j) * base.width + i];
      picture.depth[pixel] = static_cast<float>(base.depth_of(i, j, z));
    }
  }
}

}  // namespace ovoid::cpu
