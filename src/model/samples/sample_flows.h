// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>

#include "ovoid/math.h"

namespace ovoid::model {

// Value at a position of the cube [-1, 1]^3 and a time in [0, 1]. Called from many threads.
using FormulaInTime = std::function<double(const Vec3& position, double time)>;

FormulaInTime make_tornado(std::uint64_t seed);
FormulaInTime make_jet(std::uint64_t seed);

}  // namespace ovoid::model
