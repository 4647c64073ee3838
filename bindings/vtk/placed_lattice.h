// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/field.h"
#include "ovoid/math.h"

namespace ovoid::mappers {

// The same lattice somewhere else in the world: samples, coefficients and ranges are shared.
LatticeField placed(const LatticeField& field, const Affine3& world_from_data);

}  // namespace ovoid::mappers
