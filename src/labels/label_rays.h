// SPDX-License-Identifier: Apache-2.0
// What a ray meets in a label map: where what wins changes, and which way the surface there faces.
#pragma once

#include <cstdint>
#include <vector>

#include "labels/label_grid.h"
#include "ovoid/math.h"

namespace ovoid::labels {

// Labels that are drawn alike are one body, whose scores add up; between them nothing is drawn.
struct Bodies {
  using Id = std::uint16_t;
  struct Body {
    bool is_shown = false;   // its surface
    bool is_opaque = false;  // nothing behind its surface is asked for
  };
  std::vector<Id> of_rank;  // [labels]
  Id of_missing = 0;        // of what is no label
  std::vector<Body> all;

  Id of(Rank rank) const noexcept { return rank == kNoLabel ? of_missing : of_rank[rank]; }
};

// Index space; the place at t is origin + t * direction.
struct LabelRay {
  Vec3 origin, direction;
  double begin = 0, end = 0;
};

// A change of the body that wins.
struct LabelCrossing {
  double t = 0;
  Bodies::Id before = 0, behind = 0;
  // The label whose surface this is, behind it, or where that is not shown before it; kNoLabel:
  // neither is shown.
  Rank rank = kNoLabel;
  Vec3 into;  // the gradient of the score behind less that before, index space
};

// What wins where the ray begins, and then all changes along it, up to the first opaque surface.
// Returns the body at the beginning, and in `rank` its label there.
Bodies::Id trace(const LabelGrid& grid, const Bodies& bodies, const LabelRay& ray, Rank* rank,
                 std::vector<LabelCrossing>& crossings);

// The label that wins at a place in the map's bounds, index space.
Rank winner_at(const LabelGrid& grid, const Vec3& place);

}  // namespace ovoid::labels
