// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "ovoid/export.h"
#include "ovoid/lattice.h"
#include "ovoid/math.h"
#include "ovoid/render_options.h"

namespace OVOID_API ovoid {

// A box in the world; oblique if its axes are. `bounds` are in the box's own coordinates.
struct Box {
  Affine3 world_from_box = Affine3::Identity();
  Bounds3 bounds;

  Bounds3 world_bounds() const;  // axis-aligned box around its corners
};

// The cells of all samples: LatticeGeometry::index_bounds() in the lattice's own axes.
Box box_of(const LatticeGeometry& geometry);

// A part of a lattice, cut out by clip planes: nothing is copied, and near the cut the field is
// what it is in the whole. A crop by indices keeps the cells of the samples lo to hi, both
// included; one by `world` the points inside an axis-aligned box whose sides may be infinite (not
// cut).
//
// crop_planes: what RenderOptions::clip_planes needs, at most six; a side at the lattice's own face
// or at infinity takes no plane. crop_box: the box that is left, for a camera or a bounding box: by
// indices in the lattice's axes; by `world` in the lattice's axes, too, if they are parallel to the
// world's, else the world box within the lattice's world_bounds(). All throw
// Error(kInvalidArgument), naming the axis and what the data has, for an empty range, for
// indices outside the lattice, and (crop_box) for a world box that misses the lattice's bounds.
std::vector<ClipPlane> crop_planes(const LatticeGeometry& geometry, const Index3& lo,
                                   const Index3& hi);
std::vector<ClipPlane> crop_planes(const Bounds3& world);
Box crop_box(const LatticeGeometry& geometry, const Index3& lo, const Index3& hi);
Box crop_box(const LatticeGeometry& geometry, const Bounds3& world);

// The same for what is no lattice: the world box within `bounds`, the data's. Throws as above.
Box crop_box(const Bounds3& bounds, const Bounds3& world);

// A thick slice: the places within half of `thickness` (world, > 0) of a plane, as the two clip
// planes that leave them. `middle`: the plane dot(middle.normal, x) == middle.offset. In the modes
// xray, maximum, minimum and mean what is shown ends at these planes, wherever sheets lie
// (docs/numerics.md, "Cut values"). Throws Error(kInvalidArgument), naming the argument, for a
// normal without a length, numbers that are not finite, and a thickness that is not > 0.
std::array<ClipPlane, 2> slice_planes(const ClipPlane& middle, double thickness);

}  // namespace ovoid
