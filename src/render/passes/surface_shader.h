// SPDX-License-Identifier: Apache-2.0
// The colour of a surface where it is seen.
#pragma once

#include <optional>

#include "ovoid/camera.h"
#include "ovoid/look.h"
#include "ovoid/surface.h"
#include "render/passes/surface_raster.h"
#include "view/look/look_table.h"
#include "view/plan/light_volume.h"

namespace ovoid {

class SurfaceShader {
 public:
  // Keeps references to all but the camera. `light`: that which arrives; null: all of it.
  SurfaceShader(const Surface& surface, const SurfaceRaster& raster, const Camera& camera,
                const Look& look, bool shows_edges, const view::LightVolume* light);

  // Classified and lit at the fragment. Its triangle has values.
  Rgb color_of(const SurfaceFragment& fragment) const;

 private:
  const Surface& surface_;
  const SurfaceRaster& raster_;
  const Look& look_;
  const bool shows_edges_;
  const view::LightVolume* const light_;
  const view::LookTable colors_;
  const std::optional<Vec3> key_;  // none: from the eye
};

}  // namespace ovoid
