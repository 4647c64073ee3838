// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <stop_token>

#include "ovoid/export.h"
#include "ovoid/field.h"

namespace OVOID_API ovoid {

struct CoarseOptions {
  // Kernel sets alone: those whose centres lie in a box of sides up to `length` become one, however
  // many they are and whatever lies between them; a picture's pixel, for instance. World units; 0:
  // no such boxes.
  double length = 0.0;
  int threads = 0;                                  // 0: one per hardware thread
  std::stop_token stop{};                           // triggered: Error(kCancelled)
  std::function<void(double fraction)> progress{};  // in [0, 1], not decreasing; one at a time,
                                                    // from any thread
};

// A field that looks like `field` from further away, where a pixel is two spacings wide or more,
// with about an eighth of its kernels: for quick pictures while something moves. Its own coarse
// field has a 64th, and so on. docs/numerics.md, "Coarse fields", has the formulas.
//
// Lattices, Cartesian and body-centred: twice the spacing, means of samples, of the same stored
// type, scale, kernel (in spacings) and reconstruction. Cartesian ones keep their bounds: n samples
// along an axis become ceil(n / 2), n / ceil(n / 2) spacings apart, and an axis of one sample stays
// as it is. Body-centred ones end up to three quarters of an old axis vector elsewhere. The value
// range is that of `field`, so that looks do not shift. A sample is missing where less than half of
// what it stands for exists; of sums, whose integral is kept, where nothing does. Of prefiltered
// lattices the coefficients are averaged, which blurs a little more than samples would.
//
// Kernel sets: neighbours are merged, about eight into one, of the same shape, profile, attributes
// and reconstruction: mass, centre and covariance of what is merged are kept. Kernels between which
// a hole would show are left apart, and so are those of different sizes, by a factor of four or so,
// and at the borders of bricks. Value and colour ranges are found anew: of a normalized field
// they shrink, and a sum's peaks are lower.
//
// The default sampling distance follows the new spacing, and with it the unit distance of looks
// that name none: set Look::unit_distance to default_unit_distance(field) to keep opacities.
//
// The result shares nothing with `field`, and does not depend on the number of threads. Throws
// Error: kInvalidArgument for a length that is negative or not finite and for bad threads;
// kCancelled; kOutOfMemory; what the field's source throws. Cost: of lattices one pass over the
// bricks, each acquired once or, along axes of odd size, a few times; no copy of the input is held.
// Of sets a sort.
Field coarse_field(const Field& field, const CoarseOptions& options = {});

}  // namespace ovoid
