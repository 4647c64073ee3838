// SPDX-License-Identifier: Apache-2.0
#include "model/particles/kernel_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "data/parallel.h"
#include "data/scalar_visit.h"
#include "model/lattice/convert.h"
#include "ovoid/error.h"

namespace ovoid::model {

namespace {

[[noreturn]] void refuse_input(const std::string& message) {
  throw Error(ErrorCode::kInvalidArgument, message);
}

std::vector<float> floats_of(const ScalarSamples& samples, std::int64_t count) {
  const auto* first = reinterpret_cast<const float*>(samples.bytes.view.data());
  return {first, first + count};
}

}  // namespace

KernelColumns columns_of(const KernelParts& parts) {
  KernelColumns columns;
  columns.shape = parts.shape;
  columns.profile = parts.profile;
  columns.cutoff = parts.cutoff;
  columns.centers = parts.centers;
  columns.shapes = parts.shapes;
  columns.weights = parts.weights;
  for (const std::vector<float>& column : parts.values) columns.values.push_back(column);
  columns.attributes = parts.attributes;
  columns.ranges = parts.ranges;
  return columns;
}

void require_tuples(const DataArray& array, std::int64_t expected, const char* noun) {
  if (array.num_components < 1)
    refuse_input(
        fmt::format("array '{}': {} components, must be >= 1", array.name, array.num_components));
  if (array.num_tuples != expected)
    refuse_input(fmt::format("array '{}': {} tuples, must be {}, one for each of the {}",
                             array.name, array.num_tuples, expected, noun));
  // Compared by division: a product of what a dataset claims may not fit 64 bits.
  const std::size_t tuple_size =
      size_of(array.type) * static_cast<std::size_t>(array.num_components);
  const std::size_t stored = array.bytes.view.size();
  if (stored % tuple_size != 0 || stored / tuple_size != static_cast<std::size_t>(expected))
    refuse_input(fmt::format("array '{}': {} bytes, must be {} tuples of {} bytes", array.name,
                             stored, expected, tuple_size));
}

std::vector<double> load_tuples(const DataArray& array, std::int64_t expected, int components,
                                const char* noun) {
  require_tuples(array, expected, noun);
  if (array.num_components != components)
    refuse_input(fmt::format("array '{}': {} components, must be {}", array.name,
                             array.num_components, components));
  std::vector<double> numbers(static_cast<std::size_t>(expected * components));
  data::visit_scalar(array.type, [&]<class T>(std::type_identity<T>) {
    for (std::size_t i = 0; i < numbers.size(); ++i)
      numbers[i] = static_cast<double>(data::load_scalar<T>(array.bytes.view.data(),
                                                            static_cast<std::int64_t>(i))) *
                       array.value_scale +
                   array.value_offset;
  });
  return numbers;
}

namespace {

// Sizes of kernels are float32, and are compared by their squares as float64. Between them and the
// extent of all of them lie as many orders of magnitude as are left to either side.
constexpr double kLeastExtent = 1e-30, kMostExtent = 1e37;

// Of the finite positions; throws on an extent that kernels cannot have.
void check_extent(const ModelRun& run, const std::vector<double>& positions) {
  Bounds3 bounds;
  for (std::size_t i = 0; i + 2 < positions.size(); i += 3) {
    const Vec3 at(positions[i], positions[i + 1], positions[i + 2]);
    if (at.allFinite()) bounds.extend(at);
  }
  if (bounds.isEmpty()) return;
  const double extent = bounds.sizes().maxCoeff();
  if (extent == 0 || (extent >= kLeastExtent && extent <= kMostExtent)) return;
  refuse_input(
      fmt::format("'{}': its positions extend over {:g}, expected {} to {:.0e}; give "
                  "lengths in another unit",
                  run.dataset.source, extent, kLeastExtent, kMostExtent));
}

}  // namespace

std::vector<double> load_positions(const ModelRun& run) {
  const DataArray& array = run.dataset.positions;
  if (array.num_tuples < 1 && run.team == nullptr)
    refuse_input(fmt::format("'{}': has no positions", run.dataset.source));
  if (array.num_tuples >= std::numeric_limits<std::uint32_t>::max())
    refuse_input(fmt::format("'{}': {} positions, must be fewer than {}", run.dataset.source,
                             array.num_tuples, std::numeric_limits<std::uint32_t>::max()));
  if (array.type != ScalarType::kFloat32 && array.type != ScalarType::kFloat64)
    refuse_input(fmt::format("'{}': positions are {}, must be float32 or float64",
                             run.dataset.source, name_of(array.type)));
  DataArray named = array;
  if (named.name.empty()) named.name = "positions";
  named.value_scale = 1;
  named.value_offset = 0;
  std::vector<double> positions = load_tuples(named, array.num_tuples, 3, "positions");
  check_extent(run, positions);
  return positions;
}

ChosenArrays choose_arrays(const ModelRun& run) {
  ChosenArrays chosen;
  chosen.arrays.push_back(&run.dataset.array(run.options.array));
  chosen.is_cell_data = chosen.arrays[0]->is_cell_data;
  run.report.array = run.report.color_array = chosen.arrays[0]->name;
  if (run.options.color_array.empty() || run.options.color_array == chosen.arrays[0]->name)
    return chosen;
  const DataArray& color = run.dataset.array(run.options.color_array);
  if (color.is_cell_data != chosen.is_cell_data)
    refuse_input(
        fmt::format("color array '{}': has a value per {}, must have one per {} as array '{}' has",
                    color.name, color.is_cell_data ? "cell" : "node",
                    chosen.is_cell_data ? "cell" : "node", chosen.arrays[0]->name));
  chosen.arrays.push_back(&color);
  run.report.color_array = color.name;
  return chosen;
}

bool SiteValues::is_finite(std::size_t site) const noexcept {
  for (const std::vector<float>& column : columns) {
    if (!std::isfinite(column[site])) return false;
  }
  return true;
}

SiteValues load_values(const ModelRun& run, const ChosenArrays& chosen, std::int64_t num_sites,
                       const char* noun) {
  SiteValues values;
  for (const DataArray* array : chosen.arrays) {
    require_tuples(*array, num_sites, noun);
    // A colour by another array need not have the components that the first has.
    const bool is_scalar = array->num_components == 1 && array != chosen.arrays[0];
    const int component = is_scalar ? 0 : run.options.component;
    values.columns.push_back(
        floats_of(take_component(*array, {component, true, run.threads, run.stop}), num_sites));
    values.attributes.push_back({array->name, array->unit, {}});
  }
  return values;
}

std::vector<float> load_column(const ModelRun& run, const DataArray& array, std::int64_t num_sites,
                               const char* noun) {
  require_tuples(array, num_sites, noun);
  if (array.num_components != 1)
    refuse_input(
        fmt::format("array '{}': {} components, must be 1", array.name, array.num_components));
  return floats_of(take_component(array, {0, true, run.threads, run.stop}), num_sites);
}

void append_site(KernelParts& parts, const Vec3& center, const SiteValues& values,
                 std::size_t site) {
  for (int axis = 0; axis < 3; ++axis) parts.centers.push_back(center[axis]);
  if (parts.values.size() != values.columns.size()) parts.values.resize(values.columns.size());
  for (std::size_t a = 0; a < values.columns.size(); ++a)
    parts.values[a].push_back(values.columns[a][site]);
}

void append_factor(const Mat3& factor, std::vector<float>& shapes) {
  constexpr double kLeast = std::numeric_limits<float>::min();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < row; ++column)
      shapes.push_back(static_cast<float>(factor(row, column)));
    shapes.push_back(static_cast<float>(std::max(factor(row, row), kLeast)));
  }
}

}  // namespace ovoid::model
