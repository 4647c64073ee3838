// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <vector>

#include "ovoid/look.h"

namespace ovoid::view {

// The surfaces of mode kIsosurface, by rising value; at least one.
inline std::vector<Isosurface> surfaces_of(const Look& look) {
  if (look.isosurfaces.empty()) return {{look.isovalue, {}, 1.0}};
  std::vector<Isosurface> surfaces = look.isosurfaces;
  std::sort(surfaces.begin(), surfaces.end(),
            [](const Isosurface& a, const Isosurface& b) { return a.value < b.value; });
  return surfaces;
}

// Of several the one that hides and shadows most, the first of equals; else the only one.
inline double solid_isovalue(const Look& look) {
  const std::vector<Isosurface> surfaces = surfaces_of(look);
  return std::max_element(
             surfaces.begin(), surfaces.end(),
             [](const Isosurface& a, const Isosurface& b) { return a.opacity < b.opacity; })
      ->value;
}

}  // namespace ovoid::view
