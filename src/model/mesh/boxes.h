// SPDX-License-Identifier: Apache-2.0
// Axis-aligned boxes (adaptive grids), checked, and where what they fill ends.
#pragma once

#include <array>
#include <cstdint>
#include <stop_token>
#include <vector>

#include "model/particles/kernel_parts.h"

namespace ovoid::model {

struct Boxes {
  std::vector<double> centers;  // [n, 3], finite or not
  std::vector<double> edges;    // [n, 3], > 0

  std::size_t count() const noexcept { return centers.size() / 3; }
  Vec3 center(std::size_t i) const noexcept { return Vec3(centers.data() + 3 * i); }
  Vec3 edge(std::size_t i) const noexcept { return Vec3(edges.data() + 3 * i); }
};

// Throws Error(kInvalidArgument) that names the box: edges that are not positive.
Boxes load_boxes(const ModelRun& run);

// A rectangle: a face of a box, or a part of one.
struct BoxFace {
  std::uint32_t box = 0;
  std::uint8_t axis = 0;  // that it stands on
  bool is_upper = false;  // the box lies below it
  double place = 0;       // along `axis`
  // Along the axes after it, in turn: of x these are y and z, of y they are z and x.
  std::array<double, 2> lo{}, hi{};
  // Bit 2 i, of `lo[i]`, and bit 2 i + 1, of `hi[i]`: the box's own face ends there, too.
  std::uint8_t own_sides = 0;
};

// Where one box ends and no other goes on: of all faces in a plane, those of boxes below it and
// those of boxes above it cancel where they lie on each other, whatever the boxes' sizes, and the
// rest is cut into rectangles. A line through the boxes passes as many faces outwards and inwards
// as it would pass of all of them, but for pairs at one place. Boxes that overlap keep their faces
// within each other. Faces lie on a grid of a thousandth of the least edge or finer, so that those
// of boxes that touch lie at the same places to the bit; boxes without a finite place have none.
// `least_edge`: of the boxes, or of more that they are among. In no order of the boxes. Throws
// Error(kCancelled). Cost: n log n, n log^2 n where sizes meet.
std::vector<BoxFace> outer_faces(const Boxes& boxes, double least_edge,
                                 const std::stop_token& stop);

// Infinite without boxes.
double least_edge_of(const Boxes& boxes) noexcept;

}  // namespace ovoid::model
