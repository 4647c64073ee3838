// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/solid.h"

namespace ovoid::solid {

// The three edges of a cell that meet in a corner, from there, in the order of the axes; of a cell
// that is not inside out their determinant has one sign at all corners.
inline Mat3 corner_frame(const SolidMesh& mesh, std::size_t cell, int corner) noexcept {
  const auto& vertices = mesh.cells[cell];
  const Vec3 at = mesh.position(vertices[static_cast<std::size_t>(corner)]);
  Mat3 frame;
  for (int axis = 0; axis < 3; ++axis) {
    const int other = corner ^ 1 << axis;
    const double sign = other > corner ? 1 : -1;
    frame.col(axis) = sign * (mesh.position(vertices[static_cast<std::size_t>(other)]) - at);
  }
  return frame;
}

}  // namespace ovoid::solid
