// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/series.h"

namespace ovoid::model {

// Throws Error(kInvalidArgument) unless the steps of the series are one distance in time apart, but
// for a thousandth of it: so are those of a lattice in space and time.
void require_even_steps(const Series& series);

}  // namespace ovoid::model
