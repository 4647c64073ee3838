// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/frame_tables.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <tuple>
#include <utility>

namespace ovoid::cpu {
namespace {

// The nodes of ClassificationTable.
FloatBuffer classification_nodes(const view::LookTable& table, double path_in_units) {
  FloatBuffer nodes;
  float* node = nodes.reserve(std::size_t{4} * view::LookTable::kPaddedNodes);
  for (int i = 0; i < view::LookTable::kPaddedNodes; ++i, node += 4) {
    node[0] = table.red()[i];
    node[1] = table.green()[i];
    node[2] = table.blue()[i];
    node[3] = static_cast<float>(
        1.0 - std::pow(1.0 - static_cast<double>(table.opacity()[i]), path_in_units));
  }
  return nodes;
}

// A range outside of which the table has no opacity, a cell wider than it need be.
std::pair<float, float> visible_values(const view::LookTable& table) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const float* const opacity = table.opacity();
  const float* const end = opacity + view::LookTable::kNodes;
  const auto shows = [](float a) { return a > 0.0F; };
  const auto first = std::find_if(opacity, end, shows) - opacity;
  if (first == view::LookTable::kNodes) return {kInfinity, -kInfinity};
  const auto last =
      std::find_if(std::reverse_iterator(end), std::reverse_iterator(opacity), shows).base() - 1 -
      opacity;
  const auto value_at = [&](std::ptrdiff_t node) {
    return static_cast<float>(table.axis().value_of_node(static_cast<double>(node)));
  };
  // Values beyond the table read its ends.
  return {first == 0 ? -kInfinity : value_at(first - 2),
          last == view::LookTable::kCells ? kInfinity : value_at(last + 2)};
}

// As ClassificationTable says; `nodes` is what classification_nodes() made of `table`.
ClassificationTable classification_table(const view::LookTable& table, const FloatBuffer& nodes) {
  ClassificationTable result{nodes.data.get(), table.has_steps() ? table.step() : nullptr,
                             table.axis(), static_cast<float>(view::LookTable::kCells)};
  std::tie(result.visible_lo, result.visible_hi) = visible_values(table);
  return result;
}

// What IntegralTable integrates, at node i.
std::array<double, 4> integrand_at(const view::LookTable& table, int i) {
  const double opacity = table.opacity()[i];
  const double extinction =
      opacity < 1.0 ? std::min(-std::log1p(-opacity), kGreatestExtinction) : kGreatestExtinction;
  return {extinction * table.red()[i], extinction * table.green()[i], extinction * table.blue()[i],
          extinction};
}

// Fills `nodes`, and the frame's IntegralTable that points to them.
IntegralTable integral_table(const view::LookTable& table, FloatBuffer& nodes) {
  using view::LookTable;
  constexpr int kParts = 8;
  float* node = nodes.reserve(std::size_t{kParts} * LookTable::kPaddedNodes);
  const double first = table.axis().value_of_node(0);
  const double last = table.axis().value_of_node(LookTable::kCells);
  const double per_value = LookTable::kCells / (last - first);
  std::array<double, 4> sum{};
  std::array<double, 4> here = integrand_at(table, 0);
  for (int i = 0; i < LookTable::kPaddedNodes; ++i, node += kParts) {
    for (std::size_t c = 0; c < 4; ++c) {
      node[c] = static_cast<float>(sum[c]);
      node[c + 4] = static_cast<float>(sum[c] - static_cast<double>(node[c]));
    }
    if (i >= LookTable::kCells) continue;
    const std::array<double, 4> next = integrand_at(table, i + 1);
    // Of a cell with a step, each side has its share.
    const double share = table.step()[i] >= 0.0F ? static_cast<double>(table.step()[i]) : 0.5;
    const double width =
        (table.axis().value_of_node(i + 1) - table.axis().value_of_node(i)) * per_value;
    for (std::size_t c = 0; c < 4; ++c)
      sum[c] += width * (share * here[c] + (1.0 - share) * next[c]);
    here = next;
  }
  IntegralTable result;
  result.nodes = nodes.data.get();
  result.per_value = static_cast<float>(per_value);
  result.value_lo = static_cast<float>(first);
  result.value_hi = static_cast<float>(last);
  for (std::size_t c = 0; c < 4; ++c) {
    result.before[c] = static_cast<float>(integrand_at(table, 0)[c]);
    result.behind[c] = static_cast<float>(integrand_at(table, LookTable::kCells)[c]);
  }
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
  if (frame.is_preintegrated) frame.integrals = integral_table(plan.look_table, tables.integrals);
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
  constexpr double kFlat =
      1e-4;  // of the drawn range, per smallest spacing (docs/numerics.md, "Light")
  const double span = look.mode == Mode::kIsosurface
                          ? static_cast<double>(range.hi) - range.lo
                          : look.transfer_function.hi() - look.transfer_function.lo();
  const double h = plan.least_spacing;
  frame.flat_gradient_inverse =
      static_cast<float>(span > 0 ? std::min(h / (kFlat * span), 1e30) : 1e30);
}

}  // namespace ovoid::cpu
