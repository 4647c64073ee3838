// SPDX-License-Identifier: Apache-2.0
// Software drivers end a shader's loops, all of them together, after 65535 rounds, and say nothing
// of it. How many rounds a sample takes, so that a list of commands stays below.
#pragma once

#include "ovoid/depth_limits.h"
#include "ovoid/look.h"
#include "render/shared/device_layout.h"

namespace ovoid::vulkan {

inline constexpr double kMostRounds = 60000;

// What of a lattice in a frame decides how long its loops are.
struct LatticeLoops {
  double widening = 1;  // the greatest of any kernel
  int num_sublattices = 1;
  std::uint32_t flags = 0;  // of the field, as shaders have them
  Mode mode = Mode::kComposite;
  bool takes_differences = false;
  bool is_refined = false;
};

// Of all loops for one sample of a sheet, its gradient included.
double rounds_of_sample(const LatticeLoops& loops, const device::LatticeConstants& lattice);

// Of the stops that pixels pass, whatever there is between them.
double rounds_of_stops(const DepthLimits& limits);

// Where a node's share of samples is looked for, nodes being so far apart (world).
double rounds_of_spread(const device::LatticeConstants& lattice, double apart);

}  // namespace ovoid::vulkan
