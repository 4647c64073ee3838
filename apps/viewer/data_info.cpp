// SPDX-License-Identifier: Apache-2.0
#include "data_info.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <span>

#include "make_field.h"

namespace ovoid::viewer {
namespace {

template <typename Value>
void widen(ValueRange& range, const DataArray& array) {
  const auto* const values = reinterpret_cast<const Value*>(array.bytes.view.data());
  const std::size_t count = array.bytes.view.size() / sizeof(Value);
  const auto step = static_cast<std::size_t>(array.num_components);
  for (std::size_t i = 0; i < count; i += step) {
    const double value = static_cast<double>(values[i]) * array.value_scale + array.value_offset;
    if (!(std::abs(value) < 1e38)) continue;
    const auto rounded = static_cast<float>(value);
    if (range.is_empty()) range = {rounded, rounded};
    range.lo = std::min(range.lo, rounded);
    range.hi = std::max(range.hi, rounded);
  }
}

ValueRange range_of(const DataArray& array) {
  ValueRange range;
  switch (array.type) {
    case ScalarType::kUInt8:
      widen<std::uint8_t>(range, array);
      break;
    case ScalarType::kInt8:
      widen<std::int8_t>(range, array);
      break;
    case ScalarType::kUInt16:
      widen<std::uint16_t>(range, array);
      break;
    case ScalarType::kInt16:
      widen<std::int16_t>(range, array);
      break;
    case ScalarType::kUInt32:
      widen<std::uint32_t>(range, array);
      break;
    case ScalarType::kInt32:
      widen<std::int32_t>(range, array);
      break;
    case ScalarType::kUInt64:
      widen<std::uint64_t>(range, array);
      break;
    case ScalarType::kInt64:
      widen<std::int64_t>(range, array);
      break;
    case ScalarType::kFloat32:
      widen<float>(range, array);
      break;
    case ScalarType::kFloat64:
      widen<double>(range, array);
      break;
  }
  return range;
}

bool is_control_mesh(const Dataset& dataset) {
  const auto is_hexahedron = [](CellType type) {
    return type == CellType::kHexahedron || type == CellType::kVoxel;
  };
  const std::span<const CellType> types = dataset.cells.types;
  return dataset.kind == DatasetKind::kMesh && (dataset.cells.is_structured() || !types.empty()) &&
         std::all_of(types.begin(), types.end(), is_hexahedron) &&
         std::any_of(dataset.arrays.begin(), dataset.arrays.end(),
                     [](const DataArray& array) { return !array.is_cell_data; });
}

}  // namespace

std::string title_of(const cli::DataFlags& data) {
  const std::string first = std::filesystem::path(data.inputs.front()).filename().string();
  return data.inputs.size() == 1 ? first
                                 : fmt::format("{} and {} more", first, data.inputs.size() - 1);
}

std::shared_ptr<const DataInfo> info_of(const Dataset& dataset, const cli::DataFlags& data) {
  auto info = std::make_shared<DataInfo>();
  info->title = title_of(data);
  info->source = dataset.source;
  info->kind = dataset.kind;
  for (const DataArray& array : dataset.arrays) {
    info->arrays.push_back({array.name, array.unit, array.num_components, array.is_cell_data,
                            range_of(array), cli::component_of(array, cli::kUsualComponent)});
  }
  info->times = dataset.times;
  if (info->times.empty()) {
    for (std::int64_t i = 0; i < dataset.num_steps; ++i)
      info->times.push_back(static_cast<double>(i));
  }
  info->time_unit = dataset.time_unit;
  info->is_staggered = dataset.series == SeriesKind::kStaggered;
  info->step = dataset.step;
  info->is_control_mesh = is_control_mesh(dataset) && info->times.size() == 1;
  return info;
}

}  // namespace ovoid::viewer
