// SPDX-License-Identifier: Apache-2.0
#include "io/core/cf_conventions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <string_view>
#include <type_traits>
#include <utility>

#include "data/scalar_visit.h"
#include "io/core/memory.h"
#include "io/core/samples.h"

namespace ovoid::io {
namespace {

// The numbers as the type holds them; those that it does not hold are no sample.
template <typename T>
std::vector<T> numbers_as(std::span<const double> numbers) {
  std::vector<T> result;
  for (const double number : numbers) {
    if constexpr (std::is_floating_point_v<T>) {
      if (std::abs(number) <= static_cast<double>(std::numeric_limits<T>::max()))
        result.push_back(static_cast<T>(number));
    } else if (number >= static_cast<double>(std::numeric_limits<T>::lowest()) &&
               number < std::ldexp(1.0, std::numeric_limits<T>::digits) &&
               number == std::floor(number)) {
      result.push_back(static_cast<T>(number));
    }
  }
  return result;
}

template <typename T, typename Value>
Bytes without_missing(std::span<const std::byte> bytes, const std::vector<T>& missing) {
  SampleBuffer buffer;
  const std::size_t count = bytes.size() / sizeof(T);
  const auto size = static_cast<std::int64_t>(count * sizeof(Value));
  std::byte* const to = buffer.extend(size, size).data();
  for (std::size_t i = 0; i < count; ++i) {
    T sample;
    std::memcpy(&sample, bytes.data() + i * sizeof(T), sizeof(T));
    const bool is_missing = std::find(missing.begin(), missing.end(), sample) != missing.end();
    const Value value =
        is_missing ? std::numeric_limits<Value>::quiet_NaN() : static_cast<Value>(sample);
    std::memcpy(to + i * sizeof(Value), &value, sizeof(Value));
  }
  return buffer.release();
}

template <typename T>
bool holds_one_of(std::span<const std::byte> bytes, const std::vector<T>& missing) {
  for (std::size_t at = 0; at + sizeof(T) <= bytes.size(); at += sizeof(T)) {
    T sample;
    std::memcpy(&sample, bytes.data() + at, sizeof(T));
    if (std::find(missing.begin(), missing.end(), sample) != missing.end()) return true;
  }
  return false;
}

// Units of time, in CF's words or OME's, as other formats write them; others as they are.
std::string plain_time_unit(const std::string& unit) {
  static constexpr std::pair<std::string_view, const char*> kUnits[] = {
      {"second", "s"},   {"sec", "s"},  {"millisecond", "ms"}, {"microsecond", "us"},
      {"minute", "min"}, {"hour", "h"}, {"hr", "h"},           {"day", "d"}};
  const std::string_view singular =
      std::string_view(unit).substr(0, unit.size() - (unit.ends_with('s') ? 1 : 0));
  for (const auto& [name, plain] : kUnits)
    if (singular == name) return plain;
  return unit;
}

bool is_one_of(std::string_view text, std::initializer_list<std::string_view> words) {
  return std::find(words.begin(), words.end(), text) != words.end();
}

bool is_pressure(const CfAxis& attributes) {
  return is_one_of(attributes.units, {"Pa", "hPa", "kPa", "bar", "mbar", "dbar", "millibar",
                                      "millibars", "pascal", "decibar"}) ||
         attributes.standard_name == "air_pressure";
}

}  // namespace

void hide_missing_numbers(const std::string& where, std::span<const double> numbers,
                          DataArray& array, std::vector<std::string>& notes) {
  data::visit_scalar(array.type, [&]<class T>(std::type_identity<T>) {
    const std::vector<T> missing = numbers_as<T>(numbers);
    if (missing.empty() || !holds_one_of(array.bytes.view, missing)) return;
    constexpr bool is_wide = sizeof(T) >= 4 && !std::is_same_v<T, float>;
    using Value = std::conditional_t<is_wide, double, float>;
    require_memory(where,
                   static_cast<std::int64_t>(array.bytes.view.size() / sizeof(T) * sizeof(Value)));
    array.bytes = without_missing<T, Value>(array.bytes.view, missing);
    const ScalarType stored = array.type;
    array.type = is_wide ? ScalarType::kFloat64 : ScalarType::kFloat32;
    if (array.type == stored) return;
    notes.push_back(fmt::format("{}: {} becomes {}: {} stands for missing samples", where,
                                name_of(stored), name_of(array.type),
                                static_cast<double>(missing.front())));
  });
}

std::optional<std::pair<double, double>> even_places(std::span<const double> places) {
  if (places.size() < 2) return std::nullopt;
  const double step = (places.back() - places.front()) / static_cast<double>(places.size() - 1);
  if (!std::isfinite(step) || step == 0) return std::nullopt;
  constexpr double kUneven = 1e-3;  // of a step; coordinates are often float32
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double even = places[0] + static_cast<double>(i) * step;
    if (!(std::abs(places[i] - even) <= kUneven * std::abs(step))) return std::nullopt;
  }
  return std::pair(places[0], step);
}

void apply_cf_numbers(const std::string& where, const CfNumbers& numbers, DataArray& array,
                      std::vector<std::string>& notes) {
  if (!numbers.missing.empty()) hide_missing_numbers(where, numbers.missing, array, notes);
  const auto& factor = numbers.scale_factor;
  const auto& offset = numbers.add_offset;
  if (factor && std::isfinite(*factor) && *factor != 0) array.value_scale = *factor;
  if (offset && std::isfinite(*offset)) array.value_offset = *offset;
  array.unit = numbers.units;
}

std::optional<char> cf_axis(const CfAxis& attributes) {
  const std::string_view standard = attributes.standard_name, units = attributes.units;
  const std::string_view axis = attributes.axis;
  if (is_one_of(axis, {"X", "x"})) return 'x';
  if (is_one_of(axis, {"Y", "y"})) return 'y';
  if (is_one_of(axis, {"Z", "z"})) return 'z';
  if (is_one_of(axis, {"T", "t"})) return 't';
  if (standard == "realization") return 'c';
  if (standard == "time" || units.find(" since ") != std::string_view::npos) return 't';
  if (is_one_of(standard, {"longitude", "grid_longitude", "projection_x_coordinate"}) ||
      is_one_of(units,
                {"degrees_east", "degree_east", "degree_E", "degrees_E", "degreeE", "degreesE"})) {
    return 'x';
  }
  if (is_one_of(standard, {"latitude", "grid_latitude", "projection_y_coordinate"}) ||
      is_one_of(units, {"degrees_north", "degree_north", "degree_N", "degrees_N", "degreeN",
                        "degreesN"})) {
    return 'y';
  }
  if (!attributes.positive.empty() || is_pressure(attributes) ||
      is_one_of(standard, {"depth", "height", "altitude"}) ||
      is_one_of(units, {"level", "layer", "sigma_level"})) {
    return 'z';
  }
  return std::nullopt;
}

bool counts_down(const CfAxis& attributes) {
  std::string positive = attributes.positive;
  for (char& c : positive) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return positive == "down" || (positive.empty() && is_pressure(attributes));
}

bool place_by_coordinates(const std::array<std::vector<double>, 3>& places, Dataset& dataset) {
  Vec3 spacing(0, 0, 0), origin(0, 0, 0);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    const std::int64_t count = dataset.lattice.dims[i];
    const auto even = even_places(places[i]);
    const bool is_there = static_cast<std::int64_t>(places[i].size()) == count;
    if (is_there && even) {
      origin[axis] = even->first;
      spacing[axis] = even->second;
    } else if (count != 1) {
      return false;
    } else if (is_there && std::isfinite(places[i][0])) {
      origin[axis] = places[i][0];
    }
  }
  const double most = spacing.cwiseAbs().maxCoeff();
  if (!(most > 0)) return false;
  const double least = (spacing.array() == 0).select(most, spacing.cwiseAbs()).minCoeff();
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    if (spacing[axis] == 0) spacing[axis] = least;
  dataset.lattice.world_from_index.linear() = spacing.asDiagonal();
  dataset.lattice.world_from_index.translation() = origin;
  return true;
}

void set_cf_times(std::vector<double> times, const std::string& units, Dataset& dataset) {
  const bool do_rise = std::adjacent_find(times.begin(), times.end(), [](double a, double b) {
                         return !(a < b);
                       }) == times.end();
  if (dataset.num_steps < 2 || static_cast<std::int64_t>(times.size()) != dataset.num_steps ||
      !do_rise || !std::isfinite(times.front()) || !std::isfinite(times.back()))
    return;
  dataset.times = std::move(times);
  const std::size_t since = units.find(" since ");
  dataset.time_unit = plain_time_unit(units.substr(0, since));
  if (since != std::string::npos)
    dataset.notes.push_back(fmt::format("{}: times are {}", dataset.source, units));
}

}  // namespace ovoid::io
