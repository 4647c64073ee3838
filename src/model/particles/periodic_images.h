// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "ovoid/math.h"

namespace ovoid::model {

// What is near the face of a periodic box has images beyond the opposite one. Calls visit(shift)
// for each image of the box that `bounds` with `radius` around them reach into: what is at p there
// is at p + shift here.
template <class Visit>
void for_each_image(const Bounds3& periodic_box, const Bounds3& bounds, double radius,
                    const Visit& visit) {
  std::array<std::array<double, 3>, 3> shifts{};  // per axis; the first is 0
  std::array<std::size_t, 3> counts = {1, 1, 1};
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const double edge = periodic_box.sizes()[axis];
    if (bounds.min()[axis] - radius < periodic_box.min()[axis]) shifts[a][counts[a]++] = edge;
    if (bounds.max()[axis] + radius > periodic_box.max()[axis]) shifts[a][counts[a]++] = -edge;
  }
  for (std::size_t z = 0; z < counts[2]; ++z) {
    for (std::size_t y = 0; y < counts[1]; ++y) {
      for (std::size_t x = 0; x < counts[0]; ++x) {
        if (x + y + z > 0) visit(Vec3(shifts[0][x], shifts[1][y], shifts[2][z]));
      }
    }
  }
}

}  // namespace ovoid::model
