// SPDX-License-Identifier: Apache-2.0
// The surface of a mesh: where its cells end, and shells. make_surface() (model.h) makes it,
// Volume::boundary keeps a field within it and shows it, Geometry puts it into a scene (scene.h).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "ovoid/export.h"
#include "ovoid/math.h"

namespace OVOID_API ovoid {

// Triangles with a value and a normal at each corner. Faces of more corners are fans of triangles.
// Normals are means over the faces around a node that are within kFeatureAngle of the triangle's
// own: what is round looks round, an edge stays an edge. Their sign is of no account.
struct Surface {
  static constexpr double kFeatureAngle = 40.0;  // degrees

  struct Triangle {
    std::array<std::uint32_t, 3> corners{};  // of `places`
    std::array<Eigen::Vector3f, 3> normals;  // unit length
    std::array<float, 3> values{};           // of what gives colour; NaN: missing, not drawn
    std::uint8_t edges = 0;  // bit i: the side from corner i to the next is an edge of a face
    // Solid cells end here: seen from outside, corners go counterclockwise. Else of a flat cell.
    bool is_boundary = false;
  };
  std::vector<Vec3> places;  // world
  std::vector<Triangle> triangles;
  Bounds3 bounds;
  bool leaves_out_cells = false;  // there are some whose faces are not known (kOther)

  // Whether boundary triangles tell where the mesh is and where it is not.
  bool encloses_mesh() const;
};

}  // namespace ovoid
