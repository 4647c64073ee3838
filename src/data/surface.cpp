// SPDX-License-Identifier: Apache-2.0
#include "ovoid/surface.h"

#include <algorithm>

namespace ovoid {

bool Surface::encloses_mesh() const {
  return !leaves_out_cells && std::any_of(triangles.begin(), triangles.end(),
                                          [](const Triangle& t) { return t.is_boundary; });
}

}  // namespace ovoid
