// SPDX-License-Identifier: Apache-2.0
// What the marks are drawn with: lines, dots and convex shapes of one ink, kept as the signed
// distance of every pixel near them. Coverage follows from the distance, so edges are smooth,
// crossing strokes are one shape, and a halo costs nothing. The plane is cut into tiles that exist
// only where something was drawn: a line across a large picture stays cheap.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "annotate/font.h"
#include "ovoid/annotate.h"

namespace ovoid::annotate {

// How ink becomes pixels.
struct Paint {
  Rgb ink{1, 1, 1};
  double opacity = 1;
  Rgb halo{0, 0, 0};
  double halo_opacity = 0;
};

class Ink {
 public:
  // For a picture of this size; the halo ends `halo_px` from the shapes.
  Ink(int width, int height, double halo_px);

  // Pixels: x to the right, y down, pixel centres at +0.5. Any finite coordinates; what is outside
  // the picture is clipped.
  void line(const Vec2& a, const Vec2& b, double pen_px);  // round ends; a == b: a dot
  void convex(std::span<const Vec2> corners);              // either sense of rotation

  void over(Image& image, const Paint& paint) const;
  void under(Image& image, const Paint& paint) const;  // seen through what the image leaves

 private:
  static constexpr int kTile = 32;  // pixels
  using Tile = std::vector<float>;  // signed distance to the nearest shape, pixels

  template <typename Distance>
  void add(Vec2 lo, Vec2 hi, double radius, const Distance& distance);
  template <typename Blend>
  void compose(Image& image, const Paint& paint, const Blend& blend) const;

  int width_, height_, tiles_x_, tiles_y_;
  double halo_px_;
  std::vector<std::unique_ptr<Tile>> tiles_;  // [tiles_y, tiles_x]
};

}  // namespace ovoid::annotate
