// SPDX-License-Identifier: Apache-2.0
// What several have seen of one picture, each of a part of space, put together.
// docs/numerics.md, "Parts of a picture".
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "ovoid/export.h"
#include "ovoid/image.h"
#include "ovoid/look.h"

namespace OVOID_API ovoid {

// What was seen along each pixel's ray, in runs of sheets: a picture, or as much of it as somebody
// has drawn so far.
struct DeepImage {
  struct Run {
    std::int32_t first = 0, last = 0;  // pieces that end on sheets [first, last)
    // Premultiplied colour and opacity. Of the modes x-ray and mean: the integral of the value and
    // the length of the path; maximum: the greatest value; then 1 where something is defined.
    std::array<float, 4> rgba{};
    float depth = 0, front_depth = 0;  // as Image has them
    float coverage = 1;  // of the pixel, as DepthLimits has it: not yet taken from the colour
    bool operator==(const Run&) const = default;
  };

  int width = 0;  // pixels
  int height = 0;
  Mode mode = Mode::kComposite;
  std::vector<std::uint32_t> first;  // [height * width + 1], of a pixel's runs; row 0 at the top
  std::vector<Run> runs;             // each pixel's from front to back

  std::span<const Run> of_pixel(int x, int y) const {
    const std::size_t at =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    return {runs.data() + first[at], runs.data() + first[at + 1]};
  }
  // Throws Error(kInvalidArgument) that names what is wrong. Cost: once over all runs.
  void validate() const;
  bool operator==(const DeepImage&) const = default;
};

// What several have seen, in one: in each pixel the runs of all, from front to back. Throws
// Error(kInvalidArgument) where sizes or modes differ, and where two runs of a pixel claim the same
// sheet. Cost: in proportion to the runs.
DeepImage merged(std::span<const DeepImage> images);

// The picture: runs are composited from front to back, integrals are added, the greatest value is
// taken, and the look then colours values. `look`: that of the frames, but for its mode. Pictures
// of lattices and kernel sets are those of one frame without lattice sheets, to a 255th
// (docs/numerics.md). A depth is that of the run in which the opacity gets there.
Image composited(const DeepImage& image, const Look& look);

}  // namespace ovoid
