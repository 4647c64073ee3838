// SPDX-License-Identifier: Apache-2.0
// Where on each pixel's ray a volume is drawn: before what OpenGL has drawn, and in the regions
// that cropping leaves.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "ovoid/depth_limits.h"
#include "ovoid/math.h"
#include "ovoid/render_options.h"
#include "view.h"

namespace ovoid::mappers {

// Cropping of vtkVolumeMapper: two planes across each axis of the data cut them into 27 regions;
// bit x + 3 y + 9 z of `regions` says whether one of them is drawn.
struct Cropping {
  std::array<double, 6> planes{};  // x, x, y, y, z, z, data's coordinates
  unsigned regions = 0;
};

// The middle region alone, which clip planes leave.
bool is_one_box(const Cropping& cropping);
std::vector<ClipPlane> planes_of_box(const Cropping& cropping, const Affine3& world_from_data);

// Any regions.
DepthLimits region_limits(const Cropping& cropping, const Affine3& world_from_data,
                          const View& view);

// Where all planes keep the field.
DepthLimits plane_limits(std::span<const ClipPlane> planes, const View& view);

// Within a box of the world, whose sides may be infinite. A ray's places on a side are the same for
// the box beyond it.
// None for bounds (x, x, y, y, z, z) without an end.
std::optional<Bounds3> owned_box(const double bounds[6]);
// Of bounds as VTK has them, by what kernels may reach beyond their data: an eighth of the
// diagonal.
void widen(double bounds[6]);
DepthLimits box_limits(const Bounds3& world, const View& view);

// The field before the depths of the viewport's pixels, row 0 at the bottom (view.viewport_width x
// viewport_height, distances along the view axis, infinite where nothing is). Into `limits`, whose
// memory is used again.
void limits_before(std::span<const float> depths, const View& view, DepthLimits* limits);

}  // namespace ovoid::mappers
