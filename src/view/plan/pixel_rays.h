// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "view/plan/view_lattice.h"

namespace ovoid::view {

// The rays of a picture's pixels: origin + depth * direction lies at that depth from the camera
// plane, world. Between pixels both are what lies between theirs.
class PixelRays {
 public:
  explicit PixelRays(const ViewLattice& lattice)
      : origins_{lattice.eye(), Vec3::Zero(), Vec3::Zero()}, directions_(lattice.ray_direction()) {
    if (!lattice.is_parallel()) return;
    origins_ = lattice.world_map(0);
    origins_.origin -= lattice.depth(0) * lattice.view_axis();
  }

  const SheetMap& origins() const noexcept { return origins_; }
  const SheetMap& directions() const noexcept { return directions_; }

 private:
  SheetMap origins_, directions_;
};

}  // namespace ovoid::view
