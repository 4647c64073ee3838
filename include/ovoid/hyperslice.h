// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/export.h"
#include "ovoid/series.h"
#include "ovoid/slices.h"

namespace OVOID_API ovoid {

// The points of space and time where normal . (x, y, z, t) = offset; x, y, z in world units, t in
// the series' unit of time.
struct Hyperplane {
  std::array<double, 4> normal{0, 0, 0, 1};
  double offset = 0;
};

enum class SliceMethod : std::uint8_t {
  kInterpolated,  // a lattice in the plane, its samples sums over the kernels in space and time
  kExtracted,     // the samples near the plane, moved onto it: kernels of less weight the farther
                  // off they were
};

struct HypersliceOptions {
  SliceMethod method = SliceMethod::kInterpolated;
  // Of the result; none: that of the data, body-centred where steps are staggered.
  std::optional<LatticeKind> lattice;
  double spacing = 1;  // its T, in that of the data
  // In planes across one axis and on the data's own lattice and spacing sums are over that axis
  // alone, unless this is kExact.
  TimeFilter filter = TimeFilter::kFourSteps;
  std::string array;  // empty: the dataset's default
  int component = 0;
  int threads = 0;  // 0: one per hardware thread
  std::stop_token stop;
};

// A slice through a series of lattices in space and time. Distances are in T of the data's
// lattice: 1 is a spacing along each axis of a step, and a step in time (of a staggered series
// sqrt(2) steps).
//
// The slice keeps the three axes that the plane's normal, so measured, has least of, turned no
// further than they must be to lie in the plane. In the world they have the directions and lengths
// they had; where time is kept it has those of the axis that is not, of which a spacing then stands
// for a step. A plane at a time is a volume of that moment, one at an x shows time instead of x.
//
// kInterpolated: a lattice of float32, NaN where the plane leaves the data and where more than half
// of what a sample is summed from is missing. kExtracted: kernels with the array and "weight",
// exp(-2 d^2) for samples within d = 2 T, divided by what the weights of the endless lattice sum to
// on average, (pi / 2)^2 and of staggered steps half of that; reconstruction normalized. Steps are
// read one by one, in order. Throws Error: kInvalidArgument for a plane without a direction or that
// misses the data, steps that are not even (but for planes across time), anything but lattices, a
// spacing that is not finite and > 0 or makes too many samples; kOutOfMemory, kCancelled; what
// reading throws. Cost: a sample of the slice takes some 256 kernels, or 128 where steps are
// staggered; across one axis, two to four. Source: [Neophytou 2006, section 2.3].
Dataset hyperslice(const Series& series, const Hyperplane& plane,
                   const HypersliceOptions& options = {});

// Slices by planes of one normal as the steps of a series, whose times are the offsets: what an
// animation runs along, and trail_before() makes a trail of. `offsets` rise; empty: where the
// data have samples, all of them. Each is made when it is read, as hyperslice() makes it; `plane`'s
// own offset is of no account. Throws Error(kInvalidArgument) for a plane that is not across one
// axis, as the lattices of others move along them; for SliceMethod::kExtracted; for offsets that do
// not rise or miss the data; and what reading the first step throws.
std::shared_ptr<const StepSource> hyperslice_steps(std::shared_ptr<const Series> series,
                                                   const Hyperplane& plane,
                                                   std::vector<double> offsets = {},
                                                   const HypersliceOptions& options = {});

}  // namespace ovoid
