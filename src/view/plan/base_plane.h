// SPDX-License-Identifier: Apache-2.0
// Sheets that are parallel to a lattice's planes, and the picture that they make: the base plane
// (docs/numerics.md, "Lattice sheets").
#pragma once

#include <array>
#include <optional>
#include <span>

#include "ovoid/camera.h"
#include "ovoid/field.h"
#include "ovoid/look.h"
#include "ovoid/math.h"
#include "ovoid/render_options.h"

namespace ovoid::view {

// The axes of an index space, in the order in which a frame has them: along the rows of its sheets,
// from row to row, from sheet to sheet. Sheets that are parallel to the picture take them as they
// are.
using AxisOrder = std::array<int, 3>;
inline constexpr AxisOrder kOwnOrder{0, 1, 2};

inline Vec3 in_order(const Vec3& v, const AxisOrder& order) {
  return {v[order[0]], v[order[1]], v[order[2]]};
}
inline Bounds3 in_order(const Bounds3& box, const AxisOrder& order) {
  return {in_order(box.min(), order), in_order(box.max(), order)};
}
// The other way.
inline Vec3 out_of_order(const Vec3& v, const AxisOrder& order) {
  Vec3 own;
  for (int a = 0; a < 3; ++a) own[order[static_cast<std::size_t>(a)]] = v[a];
  return own;
}

// A homography of the plane: (x, y, 1) becomes (x w, y w, w).
struct PlaneMap {
  Mat3 matrix = Mat3::Identity();

  Eigen::Vector2d operator()(double x, double y) const {
    const Vec3 mapped = matrix * Vec3(x, y, 1);
    return mapped.head<2>() / mapped[2];
  }
};

// The samples of a frame's sheets. Sample (x, y) of the sheet at z lies at
//   parallel     eye + z axis + (corner + x per_x + y per_y)
//   perspective  eye + z (axis + corner + x per_x + y per_y)
// per_x and per_y run along two axis vectors of the lattice; `axis` is the camera's view axis, of
// unit length, along which sheets have the same distance as those that are parallel to the picture.
struct BasePlane {
  AxisOrder order = kOwnOrder;
  int width = 1, height = 1;                  // samples
  int picture_width = 1, picture_height = 1;  // pixels
  bool is_parallel = true;
  Vec3 eye, axis, corner, per_x, per_y;
  double samples_per_spacing = 1;  // of the lattice, at least: along either axis, on any sheet
  // The sampling distance is so much less that samples of the ray through the window's middle are
  // no farther from each other than between sheets that are parallel to the picture: 1 in parallel
  // projection.
  double closeness = 1;
  PlaneMap base_from_picture;  // of pixels, and of samples
  PlaneMap picture_from_base;
  // Depth of the sample (x, y) of the sheet at z: z + depth.at(x, y), or in perspective z *
  // depth.at(x, y).
  struct {
    double origin, per_x, per_y;
    double at(double x, double y) const { return origin + x * per_x + y * per_y; }
  } depth;

  double depth_of(double x, double y, double z) const {
    return is_parallel ? z + depth.at(x, y) : z * depth.at(x, y);
  }
};

// Samples of the base plane per pixel of the picture, along each axis.
inline constexpr double kBaseDensity = 1.0;

// The farthest that samples of the base plane may be from each other, spacings of the lattice:
// where pixels are wider there are more samples than pixels, and no kernel is widened.
inline constexpr double kMostSpacings = 4.0 / 3;

// The base plane of a lattice and a view: as dense as the picture, not much less dense than the
// lattice, around what both show. `support`: where the field can be defined, index space. Empty
// where sheets cannot lie like this: in perspective the camera has to be in front of the whole
// field, and the rays that meet it within 60 degrees of the sheets' normal; in parallel projection
// the view axis, which only oblique lattices can miss. `also`: places that the plane covers, too,
// and that are to be in front of the camera as well; world.
std::optional<BasePlane> base_plane(const LatticeField& field, const Bounds3& support,
                                    const Camera& camera, const RenderOptions& options,
                                    std::span<const Vec3> also = {});

// How many samples apart those are that are drawn first: 1, 2, 4 or 8; 1: all are drawn.
// `steepness`: of the steepest look, steepness_of().
int first_samples_apart(const BasePlane& base, double steepness, Mode mode,
                        const RenderOptions& options);

// The same plane for another lattice: its axes in such an order that they run along the base
// plane's, if they do.
struct PlaneOfOther {
  BasePlane base;
  bool is_aligned = false;     // they do, up to a thousandth of a spacing all over the plane
  double samples_apart = 0.0;  // the farthest that neighbouring samples are, spacings
};
PlaneOfOther plane_for(const BasePlane& base, const LatticeGeometry& lattice);

}  // namespace ovoid::view
