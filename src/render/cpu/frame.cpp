// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/frame.h"

#include "view/look/isosurfaces.h"
#include "view/look/look_2d.h"

namespace ovoid::cpu {
namespace {

ClassificationTable table_in(const FrameTables& tables, const device::TableConstants& constants) {
  const float* const numbers = &tables.front().x;
  ClassificationTable table{constants, numbers + std::size_t{4} * constants.entries_at, nullptr};
  if (constants.steps_at != device::kNoTable) table.steps = numbers + constants.steps_at;
  return table;
}

std::vector<FrameSurface> frame_surfaces(const Look& look) {
  std::vector<FrameSurface> surfaces;
  for (const Isosurface& surface : view::surfaces_of(look)) {
    const Rgb color = surface.color.value_or(look.transfer_function.color_at(surface.value));
    surfaces.push_back(
        {static_cast<float>(surface.value),
         static_cast<float>(surface.opacity),
         {static_cast<float>(color[0]), static_cast<float>(color[1]), static_cast<float>(color[2])},
         surface.color.has_value()});
  }
  return surfaces;
}

ClassificationPlane plane_of(const TransferFunction2D& function, const view::FramePlan& plan) {
  const TransferFunction2D::Axis& values = function.values();
  const TransferFunction2D::Axis& gradients = function.gradients();
  const auto entries_per = [](const TransferFunction2D::Axis& axis) {
    return (axis.count - 1) / (axis.last - axis.first);
  };
  ClassificationPlane plane;
  plane.entries = function.entries().front().data();
  plane.columns = values.count;
  plane.rows = gradients.count;
  plane.first_value = static_cast<float>(values.first);
  plane.columns_per_value = static_cast<float>(entries_per(values));
  plane.first_gradient = static_cast<float>(gradients.first / plan.gradient_unit);
  plane.rows_per_gradient = static_cast<float>(entries_per(gradients) * plan.gradient_unit);
  return plane;
}

}  // namespace

void set_frame(CpuFrame& frame, const Look& look, const RenderOptions& options,
               const view::FramePlan& plan, const view::LightVolume* light) {
  static_cast<FrameTraits&>(frame) = frame_traits(plan, look, options);
  frame.plan = &plan;
  frame.options = &options;
  frame.limits = options.depth_limits.get();
  frame.takes_colors_of_stops = frame.mode == Mode::kComposite || frame.mode == Mode::kIsosurface;
  frame.camera = frame_camera(plan);
  FrameLook& tables = frame.look;
  tables.constants = look_constants(plan, look, frame.corrects_late, tables.memory);
  if (frame.mode == Mode::kIsosurface) tables.surfaces = frame_surfaces(look);
  if (light != nullptr) {
    tables.constants.volume = light_constants(plan, *light);
    frame.has_key_light = light->has_key;
    frame.light = light->packed.data();
  }
  tables.table = table_in(tables.memory, tables.constants.look);
  if (!look.transfer_function.gradient_opacities.empty())
    tables.fading = table_in(tables.memory, tables.constants.fading);
  view::Variation2D in_plane;
  if (look.transfer_function_2d) {
    tables.plane = plane_of(*look.transfer_function_2d, plan);
    if (frame.is_refined) {
      in_plane = view::variation_of(*look.transfer_function_2d, plan.look_table,
                                    static_cast<double>(tables.constants.path_in_units));
      tables.plane.variation = in_plane.by_gradient;
    }
  }
  if (frame.has_own_color) tables.color = table_in(tables.memory, tables.constants.color);
  if (frame.is_refined) {
    const float* const variation = look.transfer_function_2d
                                       ? in_plane.by_value.data()
                                       : &tables.memory.front().x + tables.constants.variation_at;
    const float* const opacity = tables.table.entries + 3;
    tables.cells.resize(device::kTableCells + 1);
    for (std::size_t i = 0; i < tables.cells.size(); ++i)
      tables.cells[i] = {variation[i], variation[i + 1], opacity[4 * i], opacity[4 * i + 4]};
    if (tables.table.steps == nullptr && !look.transfer_function_2d) {
      tables.color_segments = color_segments(tables.table.entries);
      tables.variation_segments = variation_segments(tables.table.entries, variation);
    }
  }
  if (frame.is_preintegrated) tables.integrals = &tables.memory[tables.constants.integrals_at].x;
}

}  // namespace ovoid::cpu
