// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "ovoid/camera.h"
#include "ovoid/export.h"
#include "ovoid/field.h"
#include "ovoid/image.h"
#include "ovoid/look.h"
#include "ovoid/math.h"
#include "ovoid/render_options.h"
#include "ovoid/sampler.h"

namespace OVOID_API ovoid {

// What a picture was drawn of and by; all of it outlives the call.
struct PickScene {
  const Field& field;
  const FieldProbe& probe;  // of that field
  const Camera& camera;
  const Look& look;
  const RenderOptions& options;  // the picture's
};

// What a picture shows at one of its pixels.
struct Pick {
  int x = 0, y = 0;    // the pixel, row 0 at the top
  double opacity = 0;  // of the picture there, in [0, 1]
  // Of x-rays the pixel's integral, value x length.
  std::optional<double> integral;

  struct Place {
    double depth = 0;    // from the camera plane along the view axis, world units
    Vec3 position;       // world
    Vec3 direction;      // of the ray there, unit length, away from the eye
    FieldSample sample;  // the field there, wherever what is seen comes from
    // Of a lattice: the place in index space, where samples of the first sublattice have whole
    // numbers.
    std::optional<Vec3> index;
  };
  std::optional<Place> place;  // none: the pixel shows nothing, its opacity is less than 1/255
};

// The place that a pixel of a finished picture stands for (docs/numerics.md, "Picking"), and the
// field there. Modes composite and isosurface: where the opacity reaches 1/2; where it never does,
// the place that adds most to it, of isosurfaces the nearest that is seen. Maximum and minimum:
// where that value was met. X-ray and mean: the place that adds most to the sum, which is that of
// the value farthest from 0. A place that is searched for is found to a sheet; where the search
// finds nothing, as in a see-through surface, it is the nearest place that is seen. `image`: as
// render() and its kin give it, without marks, x-rays with their integrals. Throws
// Error(kInvalidArgument) for a pixel outside of it, and what the field's source throws. Cost: one
// value, or a value for each sheet of one ray.
Pick pick(const Image& image, int x, int y, const PickScene& scene);

}  // namespace ovoid
