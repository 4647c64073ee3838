// SPDX-License-Identifier: Apache-2.0
// --over: other volumes in the same picture.
#pragma once

#include <memory>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/further_volumes.h"
#include "session.h"
#include "settings.h"

namespace ovoid::cli {

// The volumes of --over, each with its look, in the world of `dataset`, which the picture is of;
// null: there are none. Throws Error.
std::shared_ptr<const std::vector<FurtherVolume>> make_over(const DrawingFlags& drawing,
                                                            const Dataset& dataset,
                                                            Session& session);

// The one of that number, in a picture whose world is in `space`. Throws Error.
FurtherVolume make_over_volume(const DrawingFlags& drawing, std::size_t i, Space space,
                               Session& session);

// The box around a field and what is drawn over it, world.
Bounds3 bounds_with(const Bounds3& bounds,
                    const std::shared_ptr<const std::vector<FurtherVolume>>& further);

}  // namespace ovoid::cli
