// SPDX-License-Identifier: Apache-2.0
// Bright things inside a body: vessels with contrast or in flow, as angiography shows them.
#pragma once

#include <optional>
#include <span>

#include "ovoid/field.h"
#include "ovoid/look.h"

namespace ovoid::view {

struct Vessels {
  double tissue;  // the value of what lies around them
  double wall;    // where they begin
  double bright;  // what nearly all of them stay below
};

// Up to 3 % of the samples that are brighter than the brightest material by as much as it stands
// out of the background, and lie deep in it: skin and fat, which are bright and thin as well, lie
// beside the background. `rising`: values of the field. None if that is not so. Cost: that of
// default_look(). Throws what the source throws.
std::optional<Vessels> find_vessels(const BrickSource& source, const Materials& materials,
                                    double background, std::span<const float> rising);

}  // namespace ovoid::view
