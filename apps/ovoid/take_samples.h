// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "ovoid/dataset.h"
#include "ovoid/field.h"
#include "session.h"

namespace ovoid::cli {

// The points as they were given, with what the field is there: the arrays "value", of fields with a
// colour of their own "color_value", "gx", "gy", "gz", "weight" (the sum of the kernels, about 1
// inside) and "defined" (0 or 1; value and gradient are NaN where it is 0). `points`: positions
// alone count. Throws Error.
Dataset take_samples(const Dataset& points, const Field& field, Session& session,
                     const std::function<void(double)>& progress);

}  // namespace ovoid::cli
