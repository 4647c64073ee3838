// SPDX-License-Identifier: Apache-2.0
// Light that crosses a coarse lattice: docs/numerics.md, "Light from a coarse volume".
#pragma once

#include <stop_token>
#include <vector>

#include "render/light/extinction_lattice.h"

namespace ovoid {

// What comes of light on its way.
struct LightWay {
  double share_of_extinction = 1;  // of the lattice's, that takes light away
  double regain = 0;               // 1 / R, per world length; 0: what is gone stays away
};

// The mean over directions of the light that arrives at each cell, in [0, 1], where 1 comes in from
// outside. `towards_light`: world, unit length, at least one. The result does not depend on
// `threads`. Cost: about 4 ns per cell and direction. Throws Error(kCancelled).
std::vector<float> mean_arriving_light(const ExtinctionLattice& lattice,
                                       const std::vector<Vec3>& towards_light, const LightWay& way,
                                       int threads, const std::stop_token& stop);

// So many directions, spread evenly over the sphere; every one has its opposite. `count` is even.
std::vector<Vec3> directions_of_sphere(int count);

// `count` directions, spread evenly over the cap around an axis of unit length, up to `angle`
// radians from it. They turn with the axis without a jump, but where it passes the world's x axis.
std::vector<Vec3> directions_of_cone(const Vec3& axis, double angle, int count);

}  // namespace ovoid
