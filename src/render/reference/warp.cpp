// SPDX-License-Identifier: Apache-2.0
#include "render/reference/warp.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace ovoid::reference {
namespace {

constexpr float kNoPlace = std::numeric_limits<float>::infinity();

// [Mitchell 1988], B = C = 1/3.
double weight(double t) {
  t = std::abs(t);
  if (t < 1) return (7 * t * t * t - 12 * t * t + 16.0 / 3) / 6;
  if (t < 2) return (-7.0 / 3 * t * t * t + 12 * t * t - 20 * t + 32.0 / 3) / 6;
  return 0;
}

// Where the centre of a pixel lies in the base plane, and how many samples as wide as it.
struct PlaceInBase {
  Eigen::Vector2d at;
  Eigen::Vector2d width;
};

PlaceInBase place_of(const view::BasePlane& base, int x, int y) {
  PlaceInBase place;
  place.at = base.base_from_picture(x, y);
  const Mat3& map = base.picture_from_base.matrix;
  const Vec3 back = map * Vec3(place.at[0], place.at[1], 1);
  for (int a = 0; a < 2; ++a) {
    const Eigen::Vector2d pixels_per_sample =
        (map.col(a).head<2>() - back.head<2>() / back[2] * map(2, a)) / back[2];
    place.width[a] = std::max(1.0, 1 / pixels_per_sample.norm());
  }
  return place;
}

float depth_of(const view::BasePlane& base, double i, double j, const std::vector<float>& depths) {
  return static_cast<float>(
      base.depth_of(i, j, depths[static_cast<std::size_t>(j * base.width + i)]));
}

}  // namespace

Image warped(const view::BasePlane& base, const Image& samples, const RenderOptions& options) {
  Image picture;
  picture.width = options.width;
  picture.height = options.height;
  const auto pixels = static_cast<std::size_t>(options.width) * options.height;
  picture.rgba.assign(4 * pixels, 0.0F);
  picture.depth.assign(pixels, kNoPlace);
  picture.front_depth.assign(pixels, kNoPlace);
  for (int y = 0; y < options.height; ++y) {
    for (int x = 0; x < options.width; ++x) {
      const PlaceInBase place = place_of(base, x, y);
      const Eigen::Vector2d& at = place.at;
      const Eigen::Vector2d& width = place.width;
      std::array<double, 4> sum{};
      std::array<double, 4> least, greatest;
      least.fill(std::numeric_limits<double>::infinity());
      greatest.fill(-std::numeric_limits<double>::infinity());
      double total = 0;
      float nearest = kNoPlace;  // of the places that samples show
      const auto first = [&](int a) { return std::ceil(at[a] - 2 * width[a]); };
      for (double j = first(1); j <= at[1] + 2 * width[1]; ++j) {
        for (double i = first(0); i <= at[0] + 2 * width[0]; ++i) {
          const double w = weight((i - at[0]) / width[0]) * weight((j - at[1]) / width[1]);
          total += w;
          const bool exists = i >= 0 && j >= 0 && i < base.width && j < base.height;
          const auto sample = exists ? static_cast<std::size_t>(j * base.width + i) : 0;
          for (std::size_t c = 0; c < 4; ++c) {
            const double value = exists ? samples.rgba[4 * sample + c] : 0.0;
            sum[c] += w * value;
            least[c] = std::min(least[c], value);
            greatest[c] = std::max(greatest[c], value);
          }
          if (exists) nearest = std::min(nearest, depth_of(base, i, j, samples.front_depth));
        }
      }
      const auto pixel = static_cast<std::size_t>(y) * options.width + x;
      for (std::size_t c = 0; c < 4; ++c) {
        picture.rgba[4 * pixel + c] =
            static_cast<float>(std::clamp(sum[c] / total, least[c], greatest[c]));
      }
      const double i = std::round(at[0]);
      const double j = std::round(at[1]);
      const bool exists = i >= 0 && j >= 0 && i < base.width && j < base.height;
      if (exists) picture.depth[pixel] = depth_of(base, i, j, samples.depth);
      if (!(picture.rgba[4 * pixel + 3] >= kLeastVisibleOpacity)) continue;
      if (exists) picture.front_depth[pixel] = depth_of(base, i, j, samples.front_depth);
      if (picture.front_depth[pixel] == kNoPlace) picture.front_depth[pixel] = nearest;
    }
  }
  return picture;
}

}  // namespace ovoid::reference
