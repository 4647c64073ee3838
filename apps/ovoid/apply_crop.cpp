// SPDX-License-Identifier: Apache-2.0
#include "apply_crop.h"

#include <fmt/format.h>

#include "ovoid/error.h"

namespace ovoid::cli {
namespace {

// The box that is left, and the planes that cut it out.
std::pair<Box, std::vector<ClipPlane>> cut(const CropFlags& crop, const Field& field) {
  if (field.lattice() == nullptr) {  // a crop by samples has been refused
    const Bounds3 bounds = field.world_bounds();
    if (!crop.world) return {{Affine3::Identity(), bounds}, {}};
    return {crop_box(bounds, *crop.world), crop_planes(*crop.world)};
  }
  const LatticeGeometry& geometry = field.lattice()->geometry();
  if (crop.world) return {crop_box(geometry, *crop.world), crop_planes(*crop.world)};
  if (!crop.samples) return {box_of(geometry), {}};
  Index3 lo{};
  Index3 hi{};
  for (std::size_t a = 0; a < 3; ++a) {
    const CropFlags::Range& range = (*crop.samples)[a];
    lo[a] = range.first.value_or(0);
    hi[a] = range.last.value_or(std::max(lo[a], geometry.dims[a] - 1));
  }
  return {crop_box(geometry, lo, hi), crop_planes(geometry, lo, hi)};
}

}  // namespace

Box apply_crop(const CropFlags& crop, const Field& field, RenderOptions* options) {
  try {
    const auto [box, planes] = cut(crop, field);
    const std::size_t given = options->clip_planes.size();
    if (given + planes.size() > RenderOptions::kMaxClipPlanes) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("crop: needs {} clip planes beside the {} of --clip, which is more "
                              "than {} in all",
                              planes.size(), given, RenderOptions::kMaxClipPlanes));
    }
    options->clip_planes.insert(options->clip_planes.end(), planes.begin(), planes.end());
    return box;
  } catch (const Error& error) {
    throw Error(error.code(), fmt::format("--{}", error.what()));
  }
}

}  // namespace ovoid::cli
