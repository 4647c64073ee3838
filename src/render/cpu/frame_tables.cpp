// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/frame_tables.h"

namespace ovoid::cpu {
namespace {

// As ClassificationTable says; `nodes` is what classification_nodes() made of `table`.
ClassificationTable classification_table(const view::LookTable& table,
                                         const std::vector<float>& nodes) {
  ClassificationTable result{nodes.data(), table.has_steps() ? table.step() : nullptr, table.axis(),
                             static_cast<float>(view::LookTable::kCells)};
  const VisibleValues visible = visible_values(table);
  result.visible_lo = visible.lo;
  result.visible_hi = visible.hi;
  return result;
}

}  // namespace

void set_view(CpuFrame& frame, const view::FramePlan& plan) {
  const view::ViewLattice& lattice = plan.lattice;
  frame.is_parallel = lattice.is_parallel();
  frame.sampling_distance = static_cast<float>(lattice.sampling_distance());
  frame.ray_direction = lattice.ray_direction();
  const view::SheetMap map = lattice.world_map(0);
  const double sign = lattice.is_parallel() || lattice.depth(0) > 0
                          ? 1.0
                          : -1.0;  // a sheet behind the eye is mirrored
  const Vec3 right = map.per_x.normalized() * sign;
  const Vec3 up = -map.per_y.normalized() * sign;
  const Vec3 axis = lattice.view_axis();
  for (int a = 0; a < 3; ++a) {
    frame.right[a] = static_cast<float>(right[a]);
    frame.up[a] = static_cast<float>(up[a]);
    frame.axis[a] = static_cast<float>(axis[a]);
  }
  const auto slope_along = [&](const Vec3& v) {
    const view::SheetMap& direction = frame.ray_direction;
    return view::ClipMap{v.dot(direction.origin), v.dot(direction.per_x), v.dot(direction.per_y)};
  };
  frame.ray_slope_right = slope_along(right);
  frame.ray_slope_up = slope_along(up);
}

void set_look(CpuFrame& frame, const ValueRange& range, const Look& look,
              const view::FramePlan& plan, LookTables& tables) {
  const bool is_composite = look.mode == Mode::kComposite;
  frame.mode = look.mode;
  frame.shade = look.shade;
  frame.is_preintegrated = is_composite && plan.is_preintegrated;
  frame.fades_by_gradient = is_composite && plan.fading.has_value();
  frame.takes_gradients = is_composite && (look.shade || frame.fades_by_gradient);
  frame.corrects_late = frame.is_preintegrated || frame.fades_by_gradient;
  const double path_in_units = plan.lattice.sampling_distance() / plan.unit_distance;
  frame.path_in_units = static_cast<float>(path_in_units);
  tables.look = classification_nodes(plan.look_table, frame.corrects_late ? 1.0 : path_in_units);
  frame.table = classification_table(plan.look_table, tables.look);
  if (frame.is_preintegrated) tables.integrals = integral_nodes(plan.look_table);
  frame.integrals = &tables.integrals;
  if (plan.color_table) {
    tables.colors = classification_nodes(*plan.color_table, 1.0);
    frame.color_table = classification_table(*plan.color_table, tables.colors);
    frame.has_own_color = true;
  }
  if (frame.fades_by_gradient) {
    tables.fading = classification_nodes(*plan.fading, 1.0);
    frame.fading = classification_table(*plan.fading, tables.fading);
  }
  frame.isovalue = static_cast<float>(look.isovalue);
  const Rgb color = look.transfer_function.color_at(look.isovalue);
  for (int c = 0; c < 3; ++c) frame.isosurface_color[c] = static_cast<float>(color[c]);
  frame.ambient = static_cast<float>(look.material.ambient);
  frame.diffuse = static_cast<float>(look.material.diffuse);
  frame.specular = static_cast<float>(look.material.specular);
  frame.specular_power = static_cast<float>(look.material.specular_power);
  frame.has_headlight = !look.light_direction.has_value();
  if (look.light_direction) {
    const Vec3 light = look.light_direction->normalized();
    for (int a = 0; a < 3; ++a) frame.light[a] = static_cast<float>(light[a]);
  }
  frame.flat_gradient_inverse = flat_gradient_inverse(look, range, plan.least_spacing);
}

}  // namespace ovoid::cpu
