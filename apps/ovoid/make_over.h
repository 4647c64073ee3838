// SPDX-License-Identifier: Apache-2.0
// --over: other volumes in the same picture.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/scene.h"
#include "session.h"
#include "settings.h"

namespace ovoid::cli {

// Why nothing of a volume would be seen in a picture of another one: it is too far away, too large
// or too small. Empty: it may be seen. Such volumes cost time and memory, since the picture's view,
// sheets and light would span both.
std::string out_of_sight(const Bounds3& volume, const Bounds3& picture);

struct OverVolume {
  std::size_t number;  // of --over
  Volume volume;
};

// The volumes of --over, each with its look, in the world of `dataset`, which the picture is of. A
// note names those that are left out, since they are out of sight. Throws Error.
std::vector<OverVolume> make_over_volumes(const DrawingFlags& drawing, const Dataset& dataset,
                                          Session& session);

// The same as a scene has them behind its first.
std::vector<Volume> make_over(const DrawingFlags& drawing, const Dataset& dataset,
                              Session& session);

// The one of that number, in a picture whose world is in `space`. Throws Error.
Volume make_over_volume(const DrawingFlags& drawing, std::size_t i, Space space, Session& session);

// The box around bounds, which are the first volume's, and all others.
Bounds3 bounds_with(const Bounds3& bounds, const Scene& scene);

}  // namespace ovoid::cli
