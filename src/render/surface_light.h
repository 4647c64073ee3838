// SPDX-License-Identifier: Apache-2.0
// The light that reaches surfaces, as the renderer makes and keeps it.
#pragma once

#include <span>
#include <string>

#include "ovoid/geometry.h"
#include "ovoid/renderer.h"
#include "ovoid/surface.h"
#include "view/light_volume.h"

namespace ovoid {

// Where light is read, in cell edges from a surface: beyond the cells that it is blurred into.
inline constexpr double kEdgesAway = 2;

// What takes light away beside the field, or in its place.
struct LightBlockers {
  const Surface* solid =
      nullptr;  // of the field's mesh, which nothing passes through; null: the field
  std::span<const Geometry> geometry{};  // valid
};

struct SurfaceLight {
  // The volume. Null: the look has none, or there is no memory for it, which the notice then says.
  // Valid until the renderer is used again, but for draw() with the same arguments.
  const view::LightVolume* volume = nullptr;
  std::string notice;

  // With geometry it is the light that draw() gives the field. Throws Error(kCancelled), and what
  // the field's source throws.
  static SurfaceLight of(Renderer& renderer, const Field& field, const LightBlockers& blockers,
                         const Camera& camera, const Look& look, const RenderOptions& options,
                         const RenderHooks& hooks);

  // Renderer::render(), in light that these take away, too.
  static Frame draw(Renderer& renderer, const Field& field, const LightBlockers& blockers,
                    const Camera& camera, const Look& look, const RenderOptions& options,
                    const RenderHooks& hooks);
};

}  // namespace ovoid
