// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "ovoid/camera.h"
#include "ovoid/field.h"
#include "ovoid/math.h"
#include "ovoid/renderer.h"

namespace ovoid::reference {

// A pixel's ray: at(z) is its point at the distance z from the camera plane, for direction . n = 1.
struct Ray {
  Vec3 origin;
  Vec3 direction;

  Vec3 at(double z) const { return origin + z * direction; }
};

// Sheets first..last; none if first > last.
struct SheetRange {
  std::int64_t first = 0;
  std::int64_t last = -1;
};

// The sample positions of one frame: docs/numerics.md, "The view lattice".
class ViewRays {
 public:
  // Camera and options are valid.
  ViewRays(const LatticeField& field, const Camera& camera, const RenderOptions& options);

  // The ray through the centre of pixel (x, y); pixels beyond the picture have one too.
  Ray ray(int x, int y) const;

  double z_of(std::int64_t sheet) const {
    return z_focal_ + (static_cast<double>(sheet) + 0.5) * ds_;
  }
  double sampling_distance() const { return ds_; }

  // False for the sheets of a perspective view at and before the near plane.
  bool exists(std::int64_t sheet) const { return !is_perspective_ || z_of(sheet) > z_near(); }

  // The factors m_a of "Minification" on a sheet, and their bounds for any sheet.
  Vec3 widening(std::int64_t sheet) const;
  Vec3 greatest_widening() const;

  // Length of the part of the sheet's segment that is before no clip plane nor the near plane.
  double path(const Ray& ray, std::int64_t sheet) const;

  // True if no clip plane cuts the world position away.
  bool is_kept(const Vec3& position) const;

  // A range that holds all sheets whose slab meets `box` (index space) along the ray.
  // Throws Error(kInvalidArgument) if the sampling distance makes them too many to count.
  SheetRange sheets_within(const Ray& ray, const Bounds3& box) const;

  // Derivatives of the sample's world position with respect to x, y and the sheet, as columns.
  Mat3 position_derivatives(const Ray& ray, std::int64_t sheet) const;

 private:
  double z_near() const { return 0.5 * ds_; }

  Affine3 index_from_world_;
  Vec3 spacing_;
  Vec3 widest_;  // dims / (4 sigma), at least 1
  std::vector<ClipPlane> clip_planes_;
  Vec3 position_;
  Vec3 forward_;  // n
  Vec3 right_;    // r
  Vec3 up_;       // q
  bool is_perspective_;
  double half_height_;  // of the picture: world units (parallel), or at z = 1 (perspective)
  int width_;
  int height_;
  double ds_;
  double z_focal_;
};

}  // namespace ovoid::reference
