// SPDX-License-Identifier: Apache-2.0
// --over: other volumes in the same picture.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/further_volumes.h"
#include "session.h"
#include "settings.h"

namespace ovoid::cli {

// Why nothing of a volume would be seen in a picture of another one: it is too far away, too large
// or too small. Empty: it may be seen. Such volumes cost time and memory, since the picture's view,
// sheets and light would span both.
std::string out_of_sight(const Bounds3& volume, const Bounds3& picture);

struct OverVolume {
  std::size_t number;  // of --over
  FurtherVolume volume;
};

// The volumes of --over, each with its look, in the world of `dataset`, which the picture is of. A
// note names those that are left out, since they are out of sight. Throws Error.
std::vector<OverVolume> make_over_volumes(const DrawingFlags& drawing, const Dataset& dataset,
                                          Session& session);

// The same as a picture takes them; null: there are none.
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
