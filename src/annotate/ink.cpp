// SPDX-License-Identifier: Apache-2.0
#include "annotate/ink.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ovoid::annotate {
namespace {

// Beyond its halo a shape still reaches half a pixel, over which coverage falls to 0.
constexpr double kEdge = 0.5;

double distance_to_segment(const Vec2& p, const Vec2& a, const Vec2& along, double length_squared) {
  const Vec2 from_a = p - a;
  const double t =
      length_squared > 0 ? std::clamp(from_a.dot(along) / length_squared, 0.0, 1.0) : 0.0;
  return (from_a - t * along).norm();
}

// Full near the shape, then falling smoothly: a rim that separates, without an edge of its own.
double halo_at(double distance, double halo_px) {
  const double t = std::clamp((halo_px + kEdge - distance) / (0.6 * halo_px + kEdge), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// Tiles touched by an interval of pixels; first > last if none.
std::pair<int, int> tiles_of(double lo, double hi, int tile, int count) {
  const double first = std::max(std::floor(lo / tile), 0.0);
  const double last = std::min(std::floor(hi / tile), count - 1.0);
  if (!(first <= last)) return {0, -1};
  return {static_cast<int>(first), static_cast<int>(last)};
}

}  // namespace

Ink::Ink(int width, int height, double halo_px)
    : width_(width),
      height_(height),
      tiles_x_((width + kTile - 1) / kTile),
      tiles_y_((height + kTile - 1) / kTile),
      halo_px_(halo_px),
      tiles_(static_cast<std::size_t>(tiles_x_) * static_cast<std::size_t>(tiles_y_)) {}

template <typename Distance>
void Ink::add(Vec2 lo, Vec2 hi, double radius, const Distance& distance) {
  const double reach = halo_px_ + kEdge;
  const Vec2 margin = Vec2::Constant(radius + reach);
  lo -= margin;
  hi += margin;
  const auto [x_first, x_last] = tiles_of(lo.x(), hi.x(), kTile, tiles_x_);
  const auto [y_first, y_last] = tiles_of(lo.y(), hi.y(), kTile, tiles_y_);
  for (int ty = y_first; ty <= y_last; ++ty) {
    for (int tx = x_first; tx <= x_last; ++tx) {
      const Vec2 corner(tx * kTile, ty * kTile);
      // Distances grow by at most 1 per pixel: from the middle, half a diagonal is 0.71 tiles.
      if (distance(corner + Vec2::Constant(kTile / 2.0)) > reach + 0.71 * kTile) continue;
      std::unique_ptr<Tile>& tile = tiles_[static_cast<std::size_t>(ty) * tiles_x_ + tx];
      if (!tile) tile = std::make_unique<Tile>(kTile * kTile, std::numeric_limits<float>::max());
      // Only the pixels that the shape and its halo can reach.
      const Vec2 least = (lo - corner).cwiseMax(0.0);
      const Vec2 most = (hi - corner).cwiseMin(kTile - 1.0);
      for (int y = static_cast<int>(least.y()); y <= most.y(); ++y) {
        for (int x = static_cast<int>(least.x()); x <= most.x(); ++x) {
          float& kept = (*tile)[static_cast<std::size_t>(y) * kTile + static_cast<std::size_t>(x)];
          const Vec2 pixel = corner + Vec2(x + 0.5, y + 0.5);
          kept = std::min(kept, static_cast<float>(distance(pixel)));
        }
      }
    }
  }
}

void Ink::line(const Vec2& a, const Vec2& b, double pen_px) {
  const Vec2 along = b - a;
  const double length_squared = along.squaredNorm();
  const double radius = pen_px / 2;
  add(a.cwiseMin(b), a.cwiseMax(b), radius,
      [&](const Vec2& p) { return distance_to_segment(p, a, along, length_squared) - radius; });
}

void Ink::convex(std::span<const Vec2> corners) {
  Vec2 lo = corners[0];
  Vec2 hi = corners[0];
  double doubled_area = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2& a = corners[i];
    const Vec2& b = corners[(i + 1) % corners.size()];
    lo = lo.cwiseMin(a);
    hi = hi.cwiseMax(a);
    doubled_area += a.x() * b.y() - a.y() * b.x();
  }
  add(lo, hi, 0, [&](const Vec2& p) {
    double inside = -std::numeric_limits<double>::max();  // greatest signed distance to a side
    double outside = std::numeric_limits<double>::max();
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vec2& a = corners[i];
      const Vec2 along = corners[(i + 1) % corners.size()] - a;
      if (along.squaredNorm() == 0) continue;
      const Vec2 normal = Vec2(along.y(), -along.x()).normalized() * (doubled_area < 0 ? -1 : 1);
      inside = std::max(inside, normal.dot(p - a));
      outside = std::min(outside, distance_to_segment(p, a, along, along.squaredNorm()));
    }
    return inside <= 0 ? inside : outside;
  });
}

template <typename Blend>
void Ink::compose(Image& image, const Paint& paint, const Blend& blend) const {
  for (std::size_t t = 0; t < tiles_.size(); ++t) {
    if (!tiles_[t]) continue;
    const int x0 = static_cast<int>(t % tiles_x_) * kTile;
    const int y0 = static_cast<int>(t / tiles_x_) * kTile;
    for (int y = y0; y < std::min(y0 + kTile, height_); ++y) {
      for (int x = x0; x < std::min(x0 + kTile, width_); ++x) {
        const double distance = (*tiles_[t])[static_cast<std::size_t>((y - y0) * kTile + x - x0)];
        if (distance >= halo_px_ + kEdge) continue;
        const double ink = paint.opacity * std::clamp(kEdge - distance, 0.0, 1.0);
        const double halo =
            (1 - ink) * paint.opacity * paint.halo_opacity * halo_at(distance, halo_px_);
        std::array<double, 4> drawn{};  // premultiplied
        for (std::size_t c = 0; c < 3; ++c) drawn[c] = ink * paint.ink[c] + halo * paint.halo[c];
        drawn[3] = ink + halo;
        blend(drawn, &image.rgba[4 * (static_cast<std::size_t>(y) * width_ + x)]);
      }
    }
  }
}

void Ink::over(Image& image, const Paint& paint) const {
  compose(image, paint, [](const std::array<double, 4>& drawn, float* pixel) {
    for (std::size_t c = 0; c < 4; ++c) {
      pixel[c] = static_cast<float>(drawn[c] + (1 - drawn[3]) * pixel[c]);
    }
  });
}

void Ink::under(Image& image, const Paint& paint) const {
  compose(image, paint, [](const std::array<double, 4>& drawn, float* pixel) {
    const double left = std::max(0.0, 1.0 - pixel[3]);
    for (std::size_t c = 0; c < 4; ++c) {
      pixel[c] = static_cast<float>(pixel[c] + left * drawn[c]);
    }
  });
}

}  // namespace ovoid::annotate
