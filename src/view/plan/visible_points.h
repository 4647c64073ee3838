// SPDX-License-Identifier: Apache-2.0
// Where a look shows something of a field, and how much: enough to know what a picture will hold
// without drawing one.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "ovoid/field.h"
#include "ovoid/look.h"
#include "ovoid/render_options.h"

namespace ovoid::view {

// A small region around a place, world units.
struct VisiblePoint {
  Vec3 place;
  double absorption;  // optical depth times area: extinction times the region's volume
  Mat3 extent;        // the region is about the image of a ball of radius 1 by this matrix
};
using VisiblePointSink = std::function<void(const VisiblePoint& point)>;

// Whether no plane cuts the place away.
bool is_kept(const Vec3& place, const std::vector<ClipPlane>& planes);

inline constexpr std::int64_t kVisiblePoints = 500'000;

// Calls the sink for about `most` samples of a lattice, evenly spread; of a set for as many kernels
// (under twice as many), or, where kernels are summed, some thousands. What lies behind clip planes
// is left out. Throws what the field's source throws.
void for_visible_points(const Field& field, const Look& look,
                        const std::vector<ClipPlane>& clip_planes, const VisiblePointSink& sink,
                        std::int64_t most = kVisiblePoints);

}  // namespace ovoid::view
