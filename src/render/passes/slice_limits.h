// SPDX-License-Identifier: Apache-2.0
// Slices through a field as limits of it.
#pragma once

#include "ovoid/camera.h"
#include "ovoid/depth_limits.h"
#include "ovoid/look.h"
#include "ovoid/render_options.h"
#include "render/field_renderer.h"

namespace ovoid {

// The plane in every pixel whose ray meets it where the field has a value, or where its outline is.
// `slice` and `labels`, of which those that show on slices are drawn, are valid; `options`' limits
// say where the field is. Throws what render() throws.
DepthLimits slice_limits(const FieldSlice& slice, const LabelSurfaces& labels,
                         FieldRenderer& renderer, const Field& field, const Camera& camera,
                         const Look& look, const RenderOptions& options, const RenderHooks& hooks);

}  // namespace ovoid
