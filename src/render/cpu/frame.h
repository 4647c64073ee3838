// SPDX-License-Identifier: Apache-2.0
// The constants of one frame that stages read and no stage writes: those that every frame has.
// Lattices add theirs in lattice_frame.h, kernel sets in kernel_block.h.
#pragma once

#include <stop_token>
#include <vector>

#include "ovoid/renderer.h"
#include "render/cpu/shade/look_segments.h"
#include "render/shared/look_values.h"
#include "render/shared/view_values.h"

namespace ovoid::cpu {

// A table of the look. An entry is red, green, blue and opacity side by side.
struct ClassificationTable {
  device::TableConstants constants{};
  const float* entries = nullptr;  // [kTableCells + 2][4], 16-byte aligned
  const float* steps = nullptr;    // [kTableCells + 1]; null if no cell has one
};

// A 2-D transfer function. An entry is red, green, blue and opacity side by side.
struct ClassificationPlane {
  const float* entries = nullptr;  // [rows][columns][4], 16-byte aligned; null: there is none
  int columns = 0, rows = 0;
  float first_value = 0, columns_per_value = 0;
  float first_gradient = 0, rows_per_gradient = 0;  // gradients in the frame's unit
  std::vector<float> variation;                     // [rows], by gradient, if is_refined
};

// One of the look's surfaces.
struct FrameSurface {
  float value;
  float opacity;
  float color[3];
  bool has_color;  // its own, whatever attribute gives the others theirs
};

// The look. Stays where it is: the tables point into its memory.
struct FrameLook {
  device::LookConstants constants{};
  ClassificationTable table;
  // If fades_by_gradient, one of the two: a factor on the opacity by the gradient's length; colour
  // and opacity by value and gradient, and then `table` is the envelope.
  ClassificationTable fading;
  ClassificationPlane plane;
  ClassificationTable color;         // colours by another attribute, if has_own_color
  const float* integrals = nullptr;  // [kTableCells + 2][8], if is_preintegrated
  FrameTables memory;
  std::vector<FrameSurface> surfaces;  // of mode isosurface, by rising value
  // If is_refined, by cell: how much the look varies up to its begin and its end, and the opacities
  // there. [kTableCells + 1]
  std::vector<device::vec4> cells;
  // If is_refined and the look has no steps, and is simple enough.
  ColorSegments color_segments;
  VariationSegments variation_segments;
};

// What every frame has, whatever its field is.
struct CpuFrame : FrameTraits {
  const view::FramePlan* plan = nullptr;
  const RenderOptions* options = nullptr;
  const DepthLimits* limits = nullptr;  // null: none
  bool takes_colors_of_stops = false;
  // What has no limits is drawn behind the field: pixels without a further span stay open, and
  // their stops wait for it.
  bool draws_beyond_limits = false;
  std::stop_token stop;
  FrameCamera camera;
  FrameLook look;
  bool has_key_light = false;    // as the light volume says
  const float* light = nullptr;  // view::LightVolume::packed; null: all light arrives

  // Whether light changes colours: those that are not lit by what arrives alone.
  bool takes_light() const noexcept { return is_lit || light != nullptr; }
};

// `options`, `plan` and `light` must live as long as the frame is drawn.
void set_frame(CpuFrame& frame, const Look& look, const RenderOptions& options,
               const view::FramePlan& plan, const view::LightVolume* light);

}  // namespace ovoid::cpu
