// SPDX-License-Identifier: Apache-2.0
// The constants of one frame that every stage reads and no stage writes.
#pragma once

#include <stop_token>

#include "ovoid/renderer.h"
#include "render/shared/lattice_values.h"
#include "render/shared/look_values.h"
#include "render/shared/view_values.h"

namespace ovoid::cpu {

// A table of the look. An entry is red, green, blue and opacity side by side.
struct ClassificationTable {
  device::TableConstants constants{};
  const float* entries = nullptr;  // [kTableCells + 2][4], 16-byte aligned
  const float* steps = nullptr;    // [kTableCells + 1]; null if no cell has one
};

// A frame of any field. Kernel sets leave the members about lattices as they are.
struct CpuFrame : FrameTraits, LatticeTraits {
  const view::FramePlan* plan = nullptr;
  const view::LatticePlan* lattice_plan = nullptr;  // `plan`, if it is a lattice's
  const LatticeField* field = nullptr;              // likewise
  const RenderOptions* options = nullptr;
  const CpuFrame* trail = nullptr;  // drawn behind this frame sheet by sheet; null: none
  std::stop_token stop;

  bool samples_at_nodes = false;  // of some sheets: tiles come in patches (nodes.h)
  FrameCamera camera;
  device::LatticeConstants lattice{};
  device::LookConstants look{};
  FrameTables tables;  // the memory that the tables below point into
  ClassificationTable table;
  ClassificationTable fading;        // opacity by the gradient's length, if fades_by_gradient
  ClassificationTable color_table;   // colours by another attribute, if has_own_color
  const float* integrals = nullptr;  // [kTableCells + 2][8], if is_preintegrated
};

// Sets the members that every field has. `options` and `plan` must live as long as the frame is
// drawn; `range`: of the field's values.
void set_frame(CpuFrame& frame, const ValueRange& range, const Look& look,
               const RenderOptions& options, const view::FramePlan& plan);

}  // namespace ovoid::cpu
