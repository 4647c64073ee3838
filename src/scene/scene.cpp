// SPDX-License-Identifier: Apache-2.0
#include "ovoid/scene.h"

#include <fmt/format.h>

#include <cmath>

#include "data/validate.h"
#include "ovoid/error.h"

namespace ovoid {
namespace {

[[noreturn]] void refuse_scene(const std::string& what) {
  throw Error(ErrorCode::kUnsupported, what);
}

// Of those behind the first.
void require_further(const Volume& volume, std::size_t number) {
  const auto refuse = [&](const char* what) {
    refuse_scene(fmt::format("volumes[{}]: {}", number, what));
  };
  if (volume.field.lattice() == nullptr)
    refuse("is a set of kernels; several volumes are lattices");
  if (volume.trail != nullptr) refuse("has a trail, which is for one volume");
  if (volume.boundary != nullptr) refuse("has a boundary, which is for the first");
}

// Parts of which a picture has one.
void require_apart(const Scene& scene) {
  const Volume& first = scene.volumes.front();
  const char* const in_place = first.points  ? "points"
                               : first.trail ? "trail"
                               : scene.plane ? "value plane"
                                             : nullptr;
  if (in_place == nullptr) return;
  if (first.points && first.trail) refuse_scene("points: are drawn without a trail");
  if ((first.points || first.trail) && scene.plane)
    refuse_scene(fmt::format("{}: not with a value plane", in_place));
  if (scene.has_scenery())
    refuse_scene(fmt::format("{}: not with surfaces, slices and labels", in_place));
  if (first.points && scene.volumes.size() > 1) refuse_scene("points: are of one volume");
}

}  // namespace

void Geometry::validate() const {
  if (surface == nullptr) throw Error(ErrorCode::kInvalidArgument, "geometry: has no surface");
  for (const double c : color) {
    if (!(c >= 0 && c <= 1))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("geometry.color: {} must be in [0, 1]", c));
  }
  if (!(opacity > 0 && opacity <= 1))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("geometry.opacity = {}: must be in (0, 1]", opacity));
  if (!colors) return;
  Look look;
  look.transfer_function = *colors;
  look.validate();
}

void FieldSlice::validate() const {
  if (!normal.allFinite() || !(normal.norm() > 0) || !std::isfinite(normal.norm()))
    throw Error(ErrorCode::kInvalidArgument, "slice.normal: must be finite and not zero");
  if (!std::isfinite(offset))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("slice.offset = {}: must be finite", offset));
  if (!(opacity > 0 && opacity <= 1))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("slice.opacity = {}: must be in (0, 1]", opacity));
  for (const double c : outline.value_or(Rgb{})) {
    if (!(c >= 0 && c <= 1))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("slice.outline: {} must be in [0, 1]", c));
  }
}

void Scene::validate() const {
  if (volumes.size() > kMaxVolumes) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("volumes: {} given, must be at most {}", volumes.size(), kMaxVolumes));
  }
  for (const Geometry& one : surfaces) one.validate();
  for (const FieldSlice& slice : slices) slice.validate();
  labels.validate();
  if (volumes.empty()) {
    const char* const of_field = !slices.empty() ? "slices" : plane ? "plane" : nullptr;
    if (of_field != nullptr) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("{}: there is no volume whose values could be shown", of_field));
    }
    if (has_scenery()) return;
    throw Error(ErrorCode::kInvalidArgument,
                "scene: there is nothing in it: expected volumes, surfaces or labels");
  }
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    if (i > 0 && volumes[i].field.is_empty()) {
      throw Error(ErrorCode::kInvalidArgument, fmt::format("volumes[{}].field: has no samples", i));
    }
    data::require_field(volumes[i].field);
    volumes[i].look.validate();
    const double walls = volumes[i].walls.opacity;
    if (!(walls >= 0 && walls <= 1)) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("walls.opacity = {}: must be in [0, 1]", walls));
    }
    if (i > 0) require_further(volumes[i], i);
  }
  if (volumes.front().points && volumes.front().field.kernels() == nullptr)
    refuse_scene("points: are for sets of kernels, the field is a lattice");
  require_apart(*this);
}

}  // namespace ovoid
