// SPDX-License-Identifier: Apache-2.0
// The field's values on a plane: a picture of them, made by the renderer itself, one sheet of
// samples that lies on the plane, and read between its texels.
#pragma once

#include <optional>
#include <vector>

#include "render/field_renderer.h"
#include "render/passes/plane_view.h"

namespace ovoid {

// Where the texels lie: the centre of (i, j) at corner + i * texel * right - j * texel * up.
struct PlaneGrid {
  Vec3 corner = Vec3::Zero();
  Vec3 right = Vec3::Zero(), up = Vec3::Zero();  // unit, world
  double texel = 1;                              // world units
  int width = 0, height = 0;

  static constexpr int kMaxSide = 2048;
};

// Immutable; values may be read from many threads.
class PlaneValues {
 public:
  // Draws the picture for what of the plane is in sight: `footprint`, at least three corners.
  // Throws what render() throws.
  PlaneValues(FieldRenderer& renderer, const Field& field, const Look& look, const PlaneView& view,
              const std::vector<Vec3>& footprint, const RenderOptions& options,
              const RenderHooks& hooks);

  // The value a pixel shows; none: the field is not defined there. Pixels wider than texels, and
  // than a lattice's spacing, show the mean over what they cover.
  std::optional<float> at(const PlaneHit& hit) const;

  const PlaneGrid& grid() const noexcept { return grid_; }
  const FrameProfile& profile() const noexcept { return profile_; }

 private:
  // In texels, from the centre of texel (0, 0), x to the right and y down.
  struct Place {
    double x, y;
  };
  Place place_of(const Vec3& at) const;
  float texel(int x, int y) const;
  std::optional<float> interpolated(const Place& place, const Vec3& at) const;
  std::optional<float> near_border(const Place& place, const Vec3& at) const;
  bool has_neighbours(const Place& place) const;
  float between(const Place& place) const;
  std::optional<float> nearest(const Place& place) const;
  bool is_within_faces(int x, int y) const;

  const PlaneView& view_;
  PlaneGrid grid_;
  double step_;  // of places within a pixel, world units
  FrameProfile profile_;
  std::vector<float> values_;  // [height, width], NaN: not defined
};

}  // namespace ovoid
