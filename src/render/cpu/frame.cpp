// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/frame.h"

namespace ovoid::cpu {
namespace {

ClassificationTable table_in(const FrameTables& tables, const device::TableConstants& constants) {
  const float* const numbers = &tables.front().x;
  ClassificationTable table{constants, numbers + std::size_t{4} * constants.entries_at, nullptr};
  if (constants.steps_at != device::kNoTable) table.steps = numbers + constants.steps_at;
  return table;
}

}  // namespace

void set_frame(CpuFrame& frame, const ValueRange& range, const Look& look,
               const RenderOptions& options, const view::FramePlan& plan) {
  static_cast<FrameTraits&>(frame) = frame_traits(plan, look, options);
  frame.plan = &plan;
  frame.options = &options;
  frame.camera = frame_camera(plan.lattice);
  frame.look = look_constants(plan, look, range, frame.corrects_late, frame.tables);
  frame.table = table_in(frame.tables, frame.look.look);
  if (frame.fades_by_gradient) frame.fading = table_in(frame.tables, frame.look.fading);
  if (frame.has_own_color) frame.color_table = table_in(frame.tables, frame.look.color);
  if (frame.is_preintegrated) frame.integrals = &frame.tables[frame.look.integrals_at].x;
}

}  // namespace ovoid::cpu
