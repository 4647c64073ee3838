// SPDX-License-Identifier: Apache-2.0
// The values that every frame has, whatever its field is: what is decided about the frame, and
// where its rays run. Every back end but the reference reads them here.
#pragma once

#include "ovoid/renderer.h"
#include "render/shared/device_layout.h"
#include "view/plan/frame_plan.h"

namespace ovoid {

// What a frame does, decided from its plan, its look and its options.
struct FrameTraits {
  Mode mode = Mode::kComposite;
  bool is_parallel = true;
  bool is_clipped = false;
  bool is_lit = true;
  bool has_own_color = false;      // another attribute gives the colours
  bool is_preintegrated = false;   // pieces between sheets are classified as one
  bool is_refined = false;         // or in steps; of the modes that show values, by their values
  bool has_pieces = false;         // what shows lies between a sheet and the one before it
  bool fades_by_gradient = false;  // the opacity depends on the gradient's length
  bool takes_gradients = true;     // for light or for fading
  bool takes_differences = false;  // the gradients are central differences
  bool fades_at_cuts = false;      // light fades towards cut faces
  bool nodes_keep_bound = false;   // nodes near a lattice's faces have no value
  float opaque_at = 1;             // a pixel is closed once its opacity has reached this
  bool corrects_late = false;      // opacities are corrected for their path after the gradient
};

FrameTraits frame_traits(const view::FramePlan& plan, const Look& look,
                         const RenderOptions& options);

// The camera's axes and the rays through the pixels.
struct FrameCamera {
  float sampling_distance = 1;
  float inverse_step = 1;  // 1 / (the sampling distance times FramePlan::gradient_unit)
  float right[3] = {}, up[3] = {}, axis[3] = {};  // world, unit length
  view::SheetMap ray;                             // of pixel (x, y), per unit of depth
  view::ClipMap slope_right{}, slope_up{};        // of that ray along `right` and `up`
};

FrameCamera frame_camera(const view::FramePlan& plan);

device::ViewConstants view_constants(const view::FramePlan& plan, const RenderOptions& options);

}  // namespace ovoid
