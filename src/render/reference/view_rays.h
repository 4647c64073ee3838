// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "ovoid/camera.h"
#include "ovoid/field.h"
#include "ovoid/math.h"
#include "ovoid/renderer.h"
#include "view/plan/base_plane.h"

namespace ovoid::reference {

// A pixel's ray: at(z) is its point at the distance z from the camera plane, for direction . n = 1.
struct Ray {
  Vec3 origin;
  Vec3 direction;

  Vec3 at(double z) const { return origin + z * direction; }
};

// From lo to hi along a ray; empty if lo > hi.
struct ZRange {
  double lo, hi;
};

// Sheets first..last; none if first > last.
struct SheetRange {
  std::int64_t first = 0;
  std::int64_t last = -1;
};

// The sample positions of one frame: docs/numerics.md, "The view lattice" and "Lattice sheets".
class ViewRays {
 public:
  // Camera and options are valid. `base`: of lattice sheets, whose samples stand for pixels and
  // whose z is that of their plane; right_of() and what follows are then meaningless. Null: of
  // image sheets.
  ViewRays(const LatticeField& field, const Camera& camera, const RenderOptions& options,
           const view::BasePlane* base = nullptr);
  // For a kernel field, whose index space is the world; widening() means nothing there.
  ViewRays(const KernelField& field, const Camera& camera, const RenderOptions& options);

  // The ray through the centre of pixel (x, y); pixels beyond the picture have one too, and so have
  // places between pixels.
  Ray ray(double x, double y) const;

  double z_of(std::int64_t sheet) const {
    return z_focal_ + (static_cast<double>(sheet) + 0.5) * ds_;
  }
  double sheet_of(double z) const { return (z - z_focal_) / ds_ - 0.5; }
  double sampling_distance() const { return ds_; }

  // False for the sheets of a perspective view at and before the near plane.
  bool exists(std::int64_t sheet) const { return !is_perspective_ || z_of(sheet) > z_near(); }

  // The factors m_a of "Minification" on a sheet, and their bounds for any sheet.
  Vec3 widening(std::int64_t sheet) const;
  Vec3 greatest_widening() const;

  // The part of `range` that no clip plane nor the near plane cuts away.
  ZRange kept(const Ray& ray, ZRange range) const;
  // Length of that part of the sheet's segment.
  double path(const Ray& ray, std::int64_t sheet) const;
  // Where the ray is inside `box` (index space).
  ZRange inside(const Ray& ray, const Bounds3& box) const;

  // Width of a pixel at the distance z, world units.
  double pitch_at(double z) const {
    return 2 * half_height_ / height_ * (is_perspective_ ? z : 1.0);
  }
  bool is_perspective() const { return is_perspective_; }
  double z_near() const { return 0.5 * ds_; }

  // Where the ray of column x or row y meets the plane at z: to the right of the view axis, and
  // below it, world units; and the column or row of such a place.
  double right_of(double x, double z) const { return (x + 0.5 - 0.5 * width_) * pitch_at(z); }
  double below_of(double y, double z) const { return (y + 0.5 - 0.5 * height_) * pitch_at(z); }
  double column_of(double right, double z) const {
    return right / pitch_at(z) - 0.5 + 0.5 * width_;
  }
  double row_of(double below, double z) const { return below / pitch_at(z) - 0.5 + 0.5 * height_; }

  // Coordinates of a world position in the camera's frame: to the right, down, and z.
  Vec3 camera_from_world(const Vec3& world) const {
    const Vec3 d = world - position_;
    return {right_.dot(d), -up_.dot(d), forward_.dot(d)};
  }
  Mat3 camera_axes() const {
    Mat3 axes;  // rows
    axes << right_.transpose(), -up_.transpose(), forward_.transpose();
    return axes;
  }

  // True if no clip plane cuts the world position away.
  bool is_kept(const Vec3& position) const;
  // The least distance behind the clip planes whose cuts are seen; none: there are none.
  std::optional<double> clearance(const Vec3& position) const;

  // A range that holds all sheets whose slab meets `box` (index space) along the ray.
  // Throws Error(kInvalidArgument) if the sampling distance makes them too many to count.
  SheetRange sheets_within(const Ray& ray, const Bounds3& box) const;

  // The farthest that a step of one pixel, along x or y, goes in index space on a sheet.
  double pixel_step(std::int64_t sheet) const;

  // Derivatives of the sample's world position with respect to x, y and the sheet, as columns.
  Mat3 position_derivatives(const Ray& ray, std::int64_t sheet) const;

 private:
  ViewRays(const Camera& camera, const RenderOptions& options, double default_distance);

  Affine3 index_from_world_ = Affine3::Identity();
  Vec3 spacing_ = Vec3::Ones();
  Vec3 widest_ = Vec3::Ones();  // dims / (4 sigma), at least 1
  std::vector<ClipPlane> clip_planes_;
  std::vector<ClipPlane> cut_faces_;  // those whose cuts are seen, normals of unit length
  Vec3 position_;
  Vec3 forward_;  // n
  Vec3 right_;    // r
  Vec3 up_;       // q
  const view::BasePlane* base_ = nullptr;
  bool is_perspective_;
  double half_height_;  // of the picture: world units (parallel), or at z = 1 (perspective)
  int width_;
  int height_;
  double ds_;
  double z_focal_;
};

}  // namespace ovoid::reference
