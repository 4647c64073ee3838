// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "ovoid/camera.h"
#include "ovoid/lattice.h"
#include "ovoid/math.h"
#include "view/plan/base_plane.h"

namespace ovoid::view {

// On one sheet, index space as an affine function of the pixel: u(x, y) = origin + x * per_x + y *
// per_y is where the centre of pixel (x, y) lies. True for parallel and perspective projection
// alike, because sheets are planes.
struct SheetMap {
  Vec3 origin;
  Vec3 per_x;
  Vec3 per_y;

  Vec3 at(double x, double y) const { return origin + x * per_x + y * per_y; }
};

// The sample positions of one frame: pixels in x and y, sheets along the view axis
// (docs/numerics.md, "The view lattice"). Sheet k is the plane at depth z_k = focal_depth + (k +
// 1/2) * sampling_distance from the camera position: parallel to the picture, or through the same
// place on the view axis and parallel to a base plane, whose samples then stand for pixels.
class ViewLattice {
 public:
  ViewLattice(const Camera& camera, int width, int height, double sampling_distance,
              const LatticeGeometry& lattice);
  // The lattice's axes are in the base plane's order.
  ViewLattice(const BasePlane& base, const Camera& camera, double sampling_distance,
              const LatticeGeometry& lattice);

  int width() const noexcept { return width_; }
  int height() const noexcept { return height_; }
  bool is_parallel() const noexcept { return is_parallel_; }
  double sampling_distance() const noexcept { return sampling_distance_; }
  double near_depth() const noexcept { return near_depth_; }  // -inf for parallel projection

  double depth(std::int64_t sheet) const noexcept {
    return focal_depth_ + (static_cast<double>(sheet) + 0.5) * sampling_distance_;
  }
  // Index-space map of a sheet, in index coordinates.
  SheetMap index_map(std::int64_t sheet) const { return map_at_depth(index_frame_, depth(sheet)); }
  // World-space map of a sheet.
  SheetMap world_map(std::int64_t sheet) const { return map_at_depth(world_frame_, depth(sheet)); }

  // Width of a pixel on a sheet, world units; of a base plane's samples that of the wider side.
  double pitch(std::int64_t sheet) const noexcept;

  // Change of world position per unit of depth along the ray of pixel (x, y): direction(x, y) =
  // origin + x * per_x + y * per_y. Its component along the view axis is 1, of sheets that are
  // parallel to the picture.
  SheetMap ray_direction() const;
  const Vec3& view_axis() const noexcept { return world_frame_.axis; }
  // World; of perspective projection.
  const Vec3& eye() const noexcept { return world_frame_.eye; }

  // Sheets [first, last) whose plane can meet the box given in index space, the near plane
  // respected; first >= last if none.
  struct SheetRange {
    std::int64_t first = 0;
    std::int64_t last = 0;
  };
  SheetRange sheets_meeting(const Bounds3& index_box) const;

 private:
  // The samples in some space: at depth 1 (perspective) or any, relative to the eye, and how they
  // change with the depth.
  struct Frame {
    Vec3 eye, axis, corner, per_x, per_y;
  };
  ViewLattice(const Frame& world, const Camera& camera, int width, int height,
              double sampling_distance, const Affine3& world_from_index);
  SheetMap map_at_depth(const Frame& frame, double depth) const;

  int width_, height_;
  bool is_parallel_;
  double sampling_distance_, near_depth_, focal_depth_;
  Frame world_frame_, index_frame_;
  double pitch_;  // parallel: world units; perspective: at depth 1
  Vec3 normal_;   // of the sheets; its product with the view axis is 1
  Affine3 world_from_index_;
};

}  // namespace ovoid::view
