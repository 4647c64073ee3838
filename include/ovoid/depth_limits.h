// SPDX-License-Identifier: Apache-2.0
// What else stands in a picture: where along each pixel's ray a field is drawn, and what is seen
// where it begins and ends. The boundary of a mesh, opaque things in the same scene and cut faces
// come into a frame this way (RenderOptions::depth_limits; docs/numerics.md, "Depth limits").
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "ovoid/export.h"

namespace OVOID_API ovoid {

struct DepthLimits {
  // A place on a pixel's ray.
  struct Stop {
    float depth = 0;  // from the camera plane along the view axis, world; -inf: before everything
    bool is_field_behind = false;  // the field is drawn from here to the next stop, or without end
    // The field does not end here, somebody else draws on: on a sheet, where a part of space does.
    bool is_seam = false;
    // What is seen here, in front of what is behind; premultiplied, in [0, 1].
    std::array<float, 4> rgba{};
  };

  int width = 0;  // pixels, as the picture's
  int height = 0;
  std::vector<std::uint32_t> first;  // [height * width + 1], of a pixel's stops; row 0 at the top
  std::vector<Stop> stops;           // each pixel's by depth; a pixel without any shows nothing
  // [height, width], in [0, 1]: how much of a pixel all this is true of; its colour and opacity are
  // multiplied by it, so that outlines are smooth. Empty: all of every pixel.
  std::vector<float> coverage;

  std::span<const Stop> of_pixel(int x, int y) const {
    const std::size_t at =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    return {stops.data() + first[at], stops.data() + first[at + 1]};
  }

  // Whether a place on a pixel's ray lies in one of its spans.
  bool shows_field_at(int x, int y, float depth) const;

  // Throws Error(kInvalidArgument) that names what is wrong. Cost: once over all stops.
  void validate() const;
};

// Spans and stops of both: the field where both draw it, without what is seen beside it. Of the
// same size; the coverage is that of `a`, if it has one, else that of `b`. Cost: once over all
// stops.
DepthLimits intersection(const DepthLimits& a, const DepthLimits& b);

}  // namespace ovoid
