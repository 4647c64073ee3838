// SPDX-License-Identifier: Apache-2.0
#include "io/zarr/zarr_places.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <type_traits>
#include <utility>

#include "data/scalar_visit.h"
#include "io/core/axis_order.h"
#include "io/core/cf_conventions.h"
#include "io/core/length_units.h"
#include "io/core/samples.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::string_view kSpaceLetters = "xyz";
constexpr std::int64_t kMostPlaces = 65'536;  // along an axis, that are looked at

// The numbers of an array of one axis; empty if there is none, or it is too long.
std::vector<double> zarr_numbers(const std::shared_ptr<const ZarrStore>& store,
                                 const std::string& key) {
  try {
    const auto node = find_zarr_node(*store, key);
    if (!node || !node->is_array) return {};
    const ChunkedArray array = zarr_array(store, *node);
    if (array.shape.size() != 1 || array.shape[0] > kMostPlaces ||
        array.chunk[0] > 16 * kMostPlaces)
      return {};
    std::vector<double> numbers;
    std::vector<std::byte> chunk(static_cast<std::size_t>(num_chunk_bytes(array)));
    for (std::int64_t i = 0; static_cast<std::int64_t>(numbers.size()) < array.shape[0]; ++i) {
      if (!load_chunk(array, std::array{i}, chunk)) return {};
      const std::int64_t left = array.shape[0] - static_cast<std::int64_t>(numbers.size());
      const auto count = static_cast<std::size_t>(std::min(left, array.chunk[0]));
      data::visit_scalar(array.type, [&]<class T>(std::type_identity<T>) {
        for (std::size_t k = 0; k < count; ++k)
          numbers.push_back(static_cast<double>(
              data::load_scalar<T>(chunk.data(), static_cast<std::int64_t>(k))));
      });
    }
    return numbers;
  } catch (const Error&) {
    return {};  // what is no array of numbers says no places
  }
}

std::optional<double> cf_number(const Json& attributes, const char* name) {
  const auto found = attributes.find(name);
  if (found == attributes.end() || !found->is_number()) return std::nullopt;
  return found->get<double>();
}

std::string cf_text(const Json& attributes, const char* name) {
  const auto found = attributes.find(name);
  return found != attributes.end() && found->is_string() ? found->get<std::string>() : "";
}

}  // namespace

void place_ome_level(const OmeImage& image, const OmeLevel& level, Dataset& dataset) {
  Vec3 spacing(1, 1, 1), origin(0, 0, 0);
  const auto unit_of = [&](char letter) {
    const auto place = axis_place(image.axes, letter);
    return place ? plain_unit(image.units[*place]) : std::string();
  };
  const std::string unit = unit_of('x');
  const std::optional<double> metres = metres_in(unit);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto place = axis_place(image.axes, kSpaceLetters[i]);
    const auto axis = static_cast<Eigen::Index>(i);
    if (!place) {
      spacing[axis] = spacing[0];  // of a plane
      continue;
    }
    const std::string own_unit = unit_of(kSpaceLetters[i]);
    const std::optional<double> own = metres_in(own_unit);
    const double factor = own && metres && own_unit != unit ? *own / *metres : 1.0;
    spacing[axis] = level.scale[*place] * factor;
    origin[axis] = level.translation[*place] * factor;
  }
  dataset.lattice.world_from_index.linear() = spacing.asDiagonal();
  dataset.lattice.world_from_index.translation() = origin;
  if (!unit.empty() && unit != "mm") {
    dataset.notes.push_back(
        fmt::format("{}: lengths are in {}, as the file has them", dataset.source, unit));
  }
  const auto time = axis_place(image.axes, 't');
  if (!time) return;
  std::vector<double> times;
  for (std::int64_t step = 0; step < dataset.num_steps; ++step)
    times.push_back(level.translation[*time] + static_cast<double>(step) * level.scale[*time]);
  set_cf_times(std::move(times), image.units[*time], dataset);
}

void place_zarr_array(const std::shared_ptr<const ZarrStore>& store, const ZarrNode& node,
                      const std::string& axes, Dataset& dataset) {
  const std::vector<std::string> names = zarr_axis_names(node);
  const std::size_t slash = node.key.rfind('/');
  const std::string group = slash == std::string::npos ? "" : node.key.substr(0, slash);
  if (node.key.empty() || names.size() != axes.size()) return;
  const auto key_along = [&](char letter) {
    const auto place = axis_place(axes, letter);
    return !place || names[*place].empty() || names[*place].find('/') != std::string::npos
               ? std::string()
               : zarr_key(group, names[*place]);
  };
  const auto places_along = [&](char letter) {
    const std::string key = key_along(letter);
    return key.empty() ? std::vector<double>() : zarr_numbers(store, key);
  };
  if (place_by_coordinates({places_along('x'), places_along('y'), places_along('z')}, dataset)) {
    dataset.notes.push_back(fmt::format(
        "{}: samples lie where the arrays beside '{}' that are called like its axes say",
        dataset.source, node.key));
  }
  std::vector<double> times = places_along('t');
  if (times.empty()) return;
  const auto time = find_zarr_node(*store, key_along('t'));
  set_cf_times(std::move(times), time ? cf_text(time->attributes, "units") : "", dataset);
}

void apply_cf_attributes(const ZarrNode& node, const std::string& where, DataArray& array,
                         std::vector<std::string>& notes) {
  const Json& attributes = node.attributes;
  CfNumbers numbers;
  for (const char* const name : {"_FillValue", "missing_value"})
    if (const auto number = cf_number(attributes, name)) numbers.missing.push_back(*number);
  // xarray says it so.
  if (attributes.contains("_ARRAY_DIMENSIONS"))
    if (const auto number = cf_number(node.description, "fill_value"))
      numbers.missing.push_back(*number);
  numbers.scale_factor = cf_number(attributes, "scale_factor");
  numbers.add_offset = cf_number(attributes, "add_offset");
  numbers.units = cf_text(attributes, "units");
  apply_cf_numbers(where, numbers, array, notes);
}

}  // namespace ovoid::io
