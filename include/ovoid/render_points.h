// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/camera.h"
#include "ovoid/export.h"
#include "ovoid/kernel_field.h"
#include "ovoid/look.h"
#include "ovoid/render_options.h"
#include "ovoid/renderer.h"

namespace OVOID_API ovoid {

struct PointStyle {
  // Of the usual radius, half a kernel's sigma: a quarter of the spacing of kernels on a grid. Of
  // an ellipsoid that is its axes' geometric mean; balls count with the median sigma at most, so
  // that lone particles, whose kernels are wide, do not hide the rest. > 0.
  double size = 1;

  static constexpr double kUsualRadius = 0.5;  // sigmas
};

// A picture of the kernels themselves, each an opaque ball about its centre, in the look's colour
// of its own value (of the colour attribute, where the field has one of its own; of fields that are
// sums the field's value is estimated from the kernel alone). Lit by the look's light and material,
// whether it lights the field or not. Outlines are smooth: four places of a pixel are looked at.
// Balls are at least 1.2 pixels wide, so that none is lost. Clip planes take whole balls, by their
// centres; so does the eye, of balls that reach it. Depth is where half of the pixel is covered,
// the front depth where any of it is. Of
// the options size and clip planes count; the look's opacities and mode do not. `threads` 0: one
// per hardware thread. The same bytes for any number. Throws Error: kInvalidArgument, kCancelled,
// kOutOfMemory, what the source throws. Cost: in proportion to the kernels, and the pixels that
// they cover.
Frame render_points(const KernelField& field, const Camera& camera, const Look& look,
                    const PointStyle& style = {}, const RenderOptions& options = {},
                    int threads = 0, const RenderHooks& hooks = {});

}  // namespace ovoid
