// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/field.h"
#include "ovoid/look.h"

namespace ovoid {

// A volume of a scene beside its first: what of Volume a frame of several is made of.
struct FurtherVolume {
  LatticeField field;
  Look look;
};

}  // namespace ovoid
