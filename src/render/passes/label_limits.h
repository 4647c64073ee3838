// SPDX-License-Identifier: Apache-2.0
// The surfaces of labels as limits of a field.
#pragma once

#include <stop_token>

#include "ovoid/camera.h"
#include "ovoid/depth_limits.h"
#include "ovoid/labels.h"
#include "ovoid/look.h"
#include "ovoid/render_options.h"
#include "view/plan/light_volume.h"

namespace ovoid {

// For every pixel the surfaces that its rays meet, lit, and where on its middle ray labels let the
// field be drawn. Clip planes cut labels open: the cut shows what it goes through. `surfaces` is
// valid and has a map. `light`: that arrives; null: all of it. Throws Error(kCancelled).
DepthLimits label_limits(const LabelSurfaces& surfaces, const Camera& camera, const Look& look,
                         const RenderOptions& options, int threads, const std::stop_token& stop,
                         const view::LightVolume* light);

}  // namespace ovoid
