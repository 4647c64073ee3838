// SPDX-License-Identifier: Apache-2.0
// Where the rays of a picture meet a value plane, and where on them the field can be.
#pragma once

#include <optional>
#include <vector>

#include "ovoid/crop.h"
#include "ovoid/scene.h"
#include "view/plan/view_lattice.h"

namespace ovoid {

// A ray of a picture: origin + depth * direction lies at that depth from the camera plane.
struct PlaneRay {
  Vec3 origin, direction;
};

// A place on the plane, and how it moves from a pixel to the next (world).
struct PlaneHit {
  Vec3 at, per_x, per_y;
  double depth = 0;
};

// Immutable.
class PlaneView {
 public:
  // All arguments are valid.
  PlaneView(const Field& field, const Camera& camera, const ValuePlane& plane,
            const RenderOptions& options);

  // Whether any ray meets the plane in front of the eye. If none does, the rest is of no use.
  bool is_met() const noexcept { return is_met_; }
  // The half spaces in front of the plane and behind it.
  const ClipPlane& front() const noexcept { return front_; }
  const ClipPlane& behind() const noexcept { return behind_; }

  PlaneRay ray(int x, int y) const;
  // Where a pixel's ray meets the plane; none: not in front of the eye, or before the near plane.
  std::optional<PlaneHit> hit(int x, int y) const;
  // Inside all of the caller's clip planes.
  bool is_kept(const Vec3& at) const;

  // Outside of a box the field is not defined.
  bool is_in_box(const Vec3& at) const;
  // Inside of its faces: of a normalized lattice, those of the outermost cells, at which a field
  // without holes is still defined.
  bool is_within_faces(const Vec3& at) const;
  // How far from the nearest of these faces, in the picture's pixels; outside of them < 0.
  double pixels_within_faces(const PlaneHit& hit) const;
  // Whether a sample of the ray's part beyond a depth may lie in the box.
  bool meets_box_beyond(const PlaneRay& ray, double depth) const;

  // The convex part of the plane where it can show, world; fewer than three corners: none.
  std::vector<Vec3> footprint() const;

  const Vec3& normal() const noexcept { return normal_; }  // of unit length, along the view
  const view::ViewLattice& lattice() const noexcept { return lattice_; }
  const Vec3& view_up() const noexcept { return up_; }  // the camera's own, of unit length
  double box_diagonal() const noexcept { return box_diagonal_; }
  double pitch_at(const Vec3& at) const;  // of a pixel at a place, world units

 private:
  void set_box(const Field& field);
  void decide_sides(const ValuePlane& plane);
  std::vector<ClipPlane> sides_of_view() const;

  int width_, height_;
  std::vector<ClipPlane> clip_planes_;
  view::ViewLattice lattice_;
  Vec3 eye_, right_, up_;
  double half_height_;                   // as ViewLattice has it
  view::SheetMap origins_, directions_;  // of rays
  Vec3 normal_;
  double offset_ = 0;
  ClipPlane front_, behind_;
  bool is_met_ = false;
  Box box_;
  Bounds3 faces_;  // in the box's own coordinates
  Affine3 box_from_world_;
  double box_diagonal_ = 0;
};

}  // namespace ovoid
