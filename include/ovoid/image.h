// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "ovoid/export.h"
#include "ovoid/transfer_function.h"

namespace OVOID_API ovoid {

// A finished picture: row 0 at the top, pixel centres at +0.5.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<float> rgba;   // [height, width, 4], premultiplied, no background in it; x-ray: the
                             // line integral in r, g, b (value x length), a = 1 where defined
  std::vector<float> depth;  // [height, width], distance from the camera plane along the view axis
                             // (world) where opacity first reaches 1/2; +inf: nowhere

  bool operator==(const Image&) const = default;
};

// 8-bit straight alpha, as PNG wants it; [height, width, 4]. `background` (r, g, b in [0, 1]) is
// blended behind.
std::vector<std::uint8_t> to_rgba8(const Image& image, const std::optional<Rgb>& background = {});

// Peak signal-to-noise ratio in dB between two pictures of equal size: peak 1, all four channels,
// over the pixels covered (alpha > 0) in either; +inf if they agree. Throws Error(kInvalidArgument)
// if the sizes differ.
double psnr(const Image& a, const Image& b);

}  // namespace ovoid
