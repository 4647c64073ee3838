// SPDX-License-Identifier: Apache-2.0
// The light that reaches the surface of a mesh, as the renderer makes and keeps it.
#pragma once

#include "ovoid/renderer.h"
#include "ovoid/surface.h"
#include "view/light_volume.h"

namespace ovoid {

// Where light is read, in cell edges from a surface: beyond the cells that it is blurred into.
inline constexpr double kEdgesAway = 2;

struct SurfaceLight {
  // The volume, of a mesh that nothing passes through, or of the field alone. Null: the look has
  // none, or there is no memory for it, which the notice then says. Valid until the renderer is
  // used again. Throws Error(kCancelled), and what the field's source throws.
  const view::LightVolume* volume = nullptr;
  std::string notice;

  // `solid`: the surface that nothing passes through; null: the field.
  static SurfaceLight of(Renderer& renderer, const Field& field, const Surface* solid,
                         const Camera& camera, const Look& look, const RenderOptions& options,
                         const RenderHooks& hooks);
};

}  // namespace ovoid
