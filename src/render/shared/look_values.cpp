// SPDX-License-Identifier: Apache-2.0
#include "render/shared/look_values.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>

#include "render/shared/device_vectors.h"
#include "view/look/look_variation.h"

namespace ovoid {

std::vector<float> classification_entries(const view::LookTable& table, double path_in_units) {
  std::vector<float> entries(std::size_t{4} * view::LookTable::kPaddedEntries);
  float* entry = entries.data();
  for (int i = 0; i < view::LookTable::kPaddedEntries; ++i, entry += 4) {
    entry[0] = table.red()[i];
    entry[1] = table.green()[i];
    entry[2] = table.blue()[i];
    entry[3] = static_cast<float>(
        1.0 - std::pow(1.0 - static_cast<double>(table.opacity()[i]), path_in_units));
  }
  return entries;
}

namespace {

// The extinction that stands for an opacity of 1: light through one unit distance of it is 1.6e-28.
constexpr double kGreatestExtinction = 64.0;

std::uint32_t append(FrameTables& tables, std::span<const float> numbers) {
  const auto at = static_cast<std::uint32_t>(tables.size());
  tables.resize(tables.size() + (numbers.size() + 3) / 4);
  std::copy(numbers.begin(), numbers.end(), &tables[at].x);
  return at;
}

// Extinction times red, green and blue, and extinction, at entry i.
std::array<double, 4> integrand_at(const view::LookTable& table, int i) {
  const double opacity = table.opacity()[i];
  const double extinction =
      opacity < 1.0 ? std::min(-std::log1p(-opacity), kGreatestExtinction) : kGreatestExtinction;
  return {extinction * table.red()[i], extinction * table.green()[i], extinction * table.blue()[i],
          extinction};
}

// A range outside of which the table has no opacity, a cell wider than it need be.
void set_visible_values(const view::LookTable& table, device::TableConstants& out) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const float* const opacity = table.opacity();
  const float* const end = opacity + view::LookTable::kEntries;
  const auto shows = [](float a) { return a > 0.0F; };
  const auto first = std::find_if(opacity, end, shows) - opacity;
  out.visible_lo = kInfinity;
  out.visible_hi = -kInfinity;
  if (first == view::LookTable::kEntries) return;
  const auto last =
      std::find_if(std::reverse_iterator(end), std::reverse_iterator(opacity), shows).base() - 1 -
      opacity;
  const auto value_at = [&](std::ptrdiff_t entry) {
    return static_cast<float>(table.axis().value_of_entry(static_cast<double>(entry)));
  };
  // Values beyond the table read its ends.
  out.visible_lo = first == 0 ? -kInfinity : value_at(first - 2);
  out.visible_hi = last == view::LookTable::kCells ? kInfinity : value_at(last + 2);
}

device::TableConstants table_constants(const view::LookTable& table, double path_in_units,
                                       FrameTables& tables) {
  const view::LookAxis& axis = table.axis();
  device::TableConstants out{};
  out.scale = static_cast<std::uint32_t>(axis.scale);
  out.origin = axis.origin;
  out.origin_bits = axis.origin_bits;
  out.cells_per_step = axis.cells_per_step;
  out.inverse_width = axis.inverse_width;
  set_visible_values(table, out);
  out.entries_at = append(tables, classification_entries(table, path_in_units));
  out.steps_at = device::kNoTable;
  if (table.has_steps())
    out.steps_at = 4 * append(tables, {table.step(), view::LookTable::kPaddedEntries});
  return out;
}

// Integrals of the look over the value, from entry 0 on: extinction times red, green and blue, and
// extinction, each as the sum of two floats, since differences are taken of large numbers. Appends
// them to `tables`, [kPaddedEntries][8]: four high parts, four low.
void set_integrals(const view::LookTable& table, device::LookConstants& out, FrameTables& tables) {
  using view::LookTable;
  constexpr int kParts = 8;
  std::vector<float> entries(std::size_t{kParts} * LookTable::kPaddedEntries);
  float* entry = entries.data();
  const double first = table.axis().value_of_entry(0);
  const double last = table.axis().value_of_entry(LookTable::kCells);
  const double per_value = LookTable::kCells / (last - first);
  std::array<double, 4> sum{};
  std::array<double, 4> here = integrand_at(table, 0);
  for (int i = 0; i < LookTable::kPaddedEntries; ++i, entry += kParts) {
    for (std::size_t c = 0; c < 4; ++c) {
      entry[c] = static_cast<float>(sum[c]);
      entry[c + 4] = static_cast<float>(sum[c] - static_cast<double>(entry[c]));
    }
    if (i >= LookTable::kCells) continue;
    const std::array<double, 4> next = integrand_at(table, i + 1);
    // Of a cell with a step, each side has its share.
    const double share = table.step()[i] >= 0.0F ? static_cast<double>(table.step()[i]) : 0.5;
    const double width =
        (table.axis().value_of_entry(i + 1) - table.axis().value_of_entry(i)) * per_value;
    for (std::size_t c = 0; c < 4; ++c)
      sum[c] += width * (share * here[c] + (1.0 - share) * next[c]);
    here = next;
  }
  out.integrals_at = append(tables, entries);
  out.integral_per_value = static_cast<float>(per_value);
  out.integral_lo = static_cast<float>(first);
  out.integral_hi = static_cast<float>(last);
  const auto integrand = [&](int i) {
    const std::array<double, 4> at = integrand_at(table, i);
    return device::vec4{static_cast<float>(at[0]), static_cast<float>(at[1]),
                        static_cast<float>(at[2]), static_cast<float>(at[3])};
  };
  out.integrals_before = integrand(0);
  out.integrals_behind = integrand(LookTable::kCells);
}

// Opacity by the gradient's length in units of `unit`.
view::LookTable fading_table(const Look& look, double unit) {
  TransferFunction by_length;
  by_length.opacities = look.transfer_function.gradient_opacities;
  for (OpacityPoint& point : by_length.opacities) point.x /= unit;
  return view::LookTable(by_length);
}

}  // namespace

device::LookConstants look_constants(const view::FramePlan& plan, const Look& look,
                                     bool corrects_late, FrameTables& tables) {
  device::LookConstants out{};
  const double path_in_units = plan.lattice.sampling_distance() / plan.unit_distance;
  out.look = table_constants(plan.look_table, corrects_late ? 1.0 : path_in_units, tables);
  if (plan.color_table) out.color = table_constants(*plan.color_table, 1.0, tables);
  if (!look.transfer_function.gradient_opacities.empty())
    out.fading = table_constants(fading_table(look, plan.gradient_unit), 1.0, tables);
  if (plan.is_preintegrated) set_integrals(plan.look_table, out, tables);
  if (plan.is_refined && !look.transfer_function_2d)
    out.variation_at = 4 * append(tables, view::look_variation(plan.look_table, path_in_units));
  const Rgb color = look.transfer_function.color_at(look.isovalue);
  out.isosurface_color = device_vector(Vec3(color[0], color[1], color[2]));
  if (look.light == Light::kStudio) {
    out.light_kind = device::kStudioLight;
  } else {
    out.light_kind = look.light_direction ? device::kSingleLight : device::kHeadlight;
  }
  if (look.light_direction) out.light = device_vector(look.light_direction->normalized());
  static_assert(device::kMaxFurtherLights == Look::kMaxFurtherLights);
  out.num_further_lights = static_cast<std::uint32_t>(look.further_lights.size());
  for (std::size_t i = 0; i < look.further_lights.size(); ++i) {
    out.further_lights[i] = device_vector(look.further_lights[i].direction.normalized());
    out.further_lights[i].w = static_cast<float>(look.further_lights[i].intensity);
  }
  out.ambient = static_cast<float>(look.material.ambient);
  out.diffuse = static_cast<float>(look.material.diffuse);
  out.specular = static_cast<float>(look.material.specular);
  out.specular_power = static_cast<float>(look.material.specular_power);
  out.flat_gradient_inverse =
      static_cast<float>(std::min(plan.gradient_unit / plan.flat_gradient, 1e30));
  out.path_in_units = static_cast<float>(path_in_units);
  out.isovalue = static_cast<float>(look.isovalue);
  return out;
}

device::LightConstants light_constants(const view::FramePlan& plan,
                                       const view::LightVolume& light) {
  device::LightConstants out{};
  const view::SheetMap first = plan.lattice.world_map(plan.sheets.first);
  const view::SheetMap direction = plan.lattice.ray_direction();
  const Mat3 linear = light.cell_from_world.linear();
  const Mat3 per_sheet = linear * plan.lattice.sampling_distance();
  out.start[0] = device_vector(light.cell_from_world * first.origin);
  out.start[1] = device_vector(linear * first.per_x);
  out.start[2] = device_vector(linear * first.per_y);
  out.step[0] = device_vector(per_sheet * direction.origin);
  out.step[1] = device_vector(per_sheet * direction.per_x);
  out.step[2] = device_vector(per_sheet * direction.per_y);
  for (int a = 0; a < 3; ++a)
    out.shift[a] = device_vector(Vec3(linear.row(a).transpose() * light.cell_edge));
  out.dims = {static_cast<std::int32_t>(light.dims[0]), static_cast<std::int32_t>(light.dims[1]),
              static_cast<std::int32_t>(light.dims[2]), 0};
  return out;
}

std::int32_t append_light(const view::LightVolume& light, FrameTables& tables) {
  return static_cast<std::int32_t>(4 * append(tables, light.packed));
}

}  // namespace ovoid
