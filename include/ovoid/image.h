// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "ovoid/camera.h"
#include "ovoid/export.h"
#include "ovoid/transfer_function.h"

namespace OVOID_API ovoid {

// The least opacity that 8 bits show.
inline constexpr float kLeastVisibleOpacity = 1.0F / 255;

// A finished picture: row 0 at the top, pixel centres at +0.5. A depth is the distance from the
// camera plane along the view axis (world), +inf: nowhere (docs/numerics.md, "Depths").
struct Image {
  int width = 0;
  int height = 0;
  std::vector<float> rgba;         // [height, width, 4], premultiplied, no background in it; x-ray:
                                   // the line integral in r, g, b (value x length), a = 1 where
                                   // defined
  std::vector<float> depth;        // [height, width], where opacity first reaches 1/2: the surface
                                   // that is seen
  std::vector<float> front_depth;  // [height, width], where opacity first reaches
                                   // kLeastVisibleOpacity: the nearest place that is seen
  std::vector<float> normals;      // [height, width, 3] of that surface, as depth_normals() makes
                                   // them; empty: none, as frames come. For write_image()

  bool operator==(const Image&) const = default;
};

// Normals of the surface that a picture of depths shows, [height, width, 3]: x, y, z in the world,
// of unit length, turned to the eye; 0 where the depth is infinite. `depths`: [height, width],
// seen with `camera`, as Image has them. Where 5 x 5 pixels lie within a pixel's width of a plane,
// the normal is that of the parabola nearest to them; elsewhere each axis takes the three pixels,
// on either side or around, that bend least, so that neither a step nor a crease is smoothed. Both
// are exact for planes. Normals are as fine as depths are, which are those of samples. `threads`
// 0: one per hardware thread; the same bytes for any number. Throws Error(kInvalidArgument) for
// another number of depths, kOutOfMemory. Cost: some 200 operations a pixel.
std::vector<float> depth_normals(std::span<const float> depths, int width, int height,
                                 const Camera& camera, int threads = 0);

// 8-bit straight alpha, as PNG wants it; [height, width, 4]. `background` (r, g, b in [0, 1]) is
// blended behind.
std::vector<std::uint8_t> to_rgba8(const Image& image, const std::optional<Rgb>& background = {});

// Peak signal-to-noise ratio in dB between two pictures of equal size: peak 1, all four channels,
// over the pixels covered (alpha > 0) in either; +inf if they agree. Throws Error(kInvalidArgument)
// if the sizes differ.
double psnr(const Image& a, const Image& b);

}  // namespace ovoid
