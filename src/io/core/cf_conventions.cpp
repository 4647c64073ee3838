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
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>

#include "data/scalar_visit.h"
#include "io/core/memory.h"
#include "io/core/number_fields.h"
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

// Which samples of a type are missing.
template <typename T>
class MissingSamples {
 public:
  explicit MissingSamples(const CfNumbers& numbers)
      : numbers_(numbers_as<Compared>(numbers.missing)) {
    // Bounds are as exact as samples: 0.1 as a double is not above 0.1 as a float.
    const auto rounded = [](double bound) {
      return std::is_same_v<T, float> &&
                     std::abs(bound) <= static_cast<double>(std::numeric_limits<float>::max())
                 ? static_cast<double>(static_cast<float>(bound))
                 : bound;
    };
    least_ = rounded(numbers.valid_min);
    most_ = rounded(numbers.valid_max);
  }

  bool is_number(T sample) const {
    return std::find(numbers_.begin(), numbers_.end(), static_cast<Compared>(sample)) !=
           numbers_.end();
  }
  bool is_outside(T sample) const {
    const auto value = static_cast<double>(sample);
    return value < least_ || value > most_;
  }
  bool operator()(T sample) const { return is_number(sample) || is_outside(sample); }

  void forget_range() {
    least_ = -std::numeric_limits<double>::infinity();
    most_ = std::numeric_limits<double>::infinity();
  }

 private:
  static constexpr bool kIsWide = std::is_integral_v<T> && sizeof(T) == 8;
  using Compared = std::conditional_t<kIsWide, double, T>;
  std::vector<Compared> numbers_;
  double least_ = 0, most_ = 0;
};

template <typename T>
T sample_at(std::span<const std::byte> bytes, std::size_t index) {
  T sample;
  std::memcpy(&sample, bytes.data() + index * sizeof(T), sizeof(T));
  return sample;
}

template <typename T, typename Value>
Bytes without_missing(std::span<const std::byte> bytes, const MissingSamples<T>& is_missing) {
  SampleBuffer buffer;
  const std::size_t count = bytes.size() / sizeof(T);
  const auto size = static_cast<std::int64_t>(count * sizeof(Value));
  std::byte* const to = buffer.extend(size, size).data();
  for (std::size_t i = 0; i < count; ++i) {
    const T sample = sample_at<T>(bytes, i);
    const Value value =
        is_missing(sample) ? std::numeric_limits<Value>::quiet_NaN() : static_cast<Value>(sample);
    std::memcpy(to + i * sizeof(Value), &value, sizeof(Value));
  }
  return buffer.release();
}

// What of an array is missing, and whether anything is left.
struct MissingCounts {
  std::optional<double> number;  // the first that stands for a missing sample
  std::int64_t num_outside = 0, num_left = 0;
};

template <typename T>
MissingCounts count_missing(std::span<const std::byte> bytes, const MissingSamples<T>& missing) {
  MissingCounts counts;
  for (std::size_t i = 0; i < bytes.size() / sizeof(T); ++i) {
    const T sample = sample_at<T>(bytes, i);
    if (missing.is_number(sample)) {
      if (!counts.number) counts.number = static_cast<double>(sample);
    } else if (missing.is_outside(sample)) {
      ++counts.num_outside;
    } else if (sample == sample) {
      ++counts.num_left;
    }
  }
  return counts;
}

// What the netCDF library fills numbers of a type with that nobody has written; bytes have none.
std::optional<double> netcdf_fill(ScalarType type) {
  switch (type) {
    case ScalarType::kInt16:
      return -32767;
    case ScalarType::kUInt16:
      return 65535;
    case ScalarType::kInt32:
      return -2147483647;
    case ScalarType::kUInt32:
      return 4294967295;
    case ScalarType::kInt64:
      return -9223372036854775806.0;
    case ScalarType::kUInt64:
      return 18446744073709551614.0;
    case ScalarType::kFloat32:
    case ScalarType::kFloat64:
      return 9.9692099683868690e+36;
    default:
      return std::nullopt;
  }
}

// The valid range of the numbers as stored. NUG: a range of the wider type that values are unpacked
// to is one of unpacked values.
void set_valid_range(const CfAttributes& attributes, ScalarType type, CfNumbers& numbers) {
  double least = numbers.valid_min, most = numbers.valid_max;
  const auto take = [&](const char* name, std::size_t index, double& bound) {
    const CfAttribute* const found = find_cf(attributes, name);
    if (found == nullptr || found->numbers.size() <= index) return;
    double value = found->numbers[index];
    if (std::isnan(value)) return;
    const bool is_unpacked = !is_floating(type) && found->type && is_floating(*found->type) &&
                             (numbers.scale_factor || numbers.add_offset);
    if (is_unpacked)
      value = (value - numbers.add_offset.value_or(0)) / numbers.scale_factor.value_or(1);
    else if (cf_text(attributes, "_Unsigned") == "true" && value < 0)
      value += std::ldexp(1.0, static_cast<int>(8 * size_of(type)));
    bound = value;
  };
  take("valid_min", 0, least);
  take("valid_max", 0, most);
  const CfAttribute* const range = find_cf(attributes, "valid_range");
  if (range != nullptr && range->numbers.size() == 2) {
    take("valid_range", 0, least);
    take("valid_range", 1, most);
  }
  // A negative factor turns an unpacked range over.
  if (least > most && numbers.scale_factor && *numbers.scale_factor < 0) std::swap(least, most);
  if (!(least <= most)) return;
  numbers.valid_min = least;
  numbers.valid_max = most;
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
  return is_one_of(attributes.units, {"Pa", "hPa", "kPa", "bar", "mb", "mbar", "dbar", "millibar",
                                      "millibars", "pascal", "decibar"}) ||
         attributes.standard_name == "air_pressure";
}

}  // namespace

const CfAttribute* find_cf(const CfAttributes& attributes, std::string_view name) {
  const auto found =
      std::find_if(attributes.begin(), attributes.end(),
                   [&](const CfAttribute& attribute) { return attribute.name == name; });
  return found == attributes.end() ? nullptr : &*found;
}

std::string cf_text(const CfAttributes& attributes, std::string_view name) {
  const CfAttribute* const found = find_cf(attributes, name);
  if (found == nullptr) return {};
  constexpr const char* kBlanks = " \t\r\n";
  const std::size_t begin = found->text.find_first_not_of(kBlanks);
  if (begin == std::string::npos) return {};
  return found->text.substr(begin, found->text.find_last_not_of(kBlanks) - begin + 1);
}

std::vector<double> cf_numbers_of(const CfAttributes& attributes, std::string_view name) {
  const CfAttribute* const found = find_cf(attributes, name);
  if (found == nullptr || !found->numbers.empty())
    return found ? found->numbers : std::vector<double>();
  const std::string text = cf_text(attributes, name);
  const auto number = text.empty() ? std::nullopt : parse_field(text);
  return number ? std::vector{*number} : std::vector<double>();
}

std::optional<double> cf_number(const CfAttributes& attributes, std::string_view name) {
  const std::vector<double> numbers = cf_numbers_of(attributes, name);
  return numbers.empty() ? std::nullopt : std::optional(numbers.front());
}

ScalarType cf_type(const CfAttributes& attributes, ScalarType stored) {
  if (cf_text(attributes, "_Unsigned") != "true") return stored;
  switch (stored) {
    case ScalarType::kInt8:
      return ScalarType::kUInt8;
    case ScalarType::kInt16:
      return ScalarType::kUInt16;
    case ScalarType::kInt32:
      return ScalarType::kUInt32;
    case ScalarType::kInt64:
      return ScalarType::kUInt64;
    default:
      return stored;
  }
}

CfNumbers cf_numbers(const CfAttributes& attributes, ScalarType type, CfFill fill) {
  CfNumbers numbers;
  for (const char* const name : {"_FillValue", "missing_value"})
    for (const double number : cf_numbers_of(attributes, name)) numbers.missing.push_back(number);
  if (cf_text(attributes, "_Unsigned") == "true")
    for (double& number : numbers.missing)
      number += number < 0 ? std::ldexp(1.0, static_cast<int>(8 * size_of(type))) : 0;
  if (fill == CfFill::kOfNetcdf && find_cf(attributes, "_FillValue") == nullptr)
    if (const auto number = netcdf_fill(type)) numbers.missing.push_back(*number);
  numbers.scale_factor = cf_number(attributes, "scale_factor");
  numbers.add_offset = cf_number(attributes, "add_offset");
  numbers.units = cf_text(attributes, "units");
  set_valid_range(attributes, type, numbers);
  return numbers;
}

void hide_missing_numbers(const std::string& where, const CfNumbers& numbers, DataArray& array,
                          std::vector<std::string>& notes) {
  data::visit_scalar(array.type, [&]<class T>(std::type_identity<T>) {
    MissingSamples<T> missing(numbers);
    MissingCounts counts = count_missing<T>(array.bytes.view, missing);
    const std::string range =
        fmt::format("the valid range, {} to {}", numbers.valid_min, numbers.valid_max);
    if (counts.num_outside > 0 && counts.num_left == 0) {
      notes.push_back(fmt::format("{}: no sample lies in {}: it is passed over", where, range));
      missing.forget_range();
      counts.num_outside = 0;
    }
    if (!counts.number && counts.num_outside == 0) return;
    constexpr bool is_wide = sizeof(T) >= 4 && !std::is_same_v<T, float>;
    using Value = std::conditional_t<is_wide, double, float>;
    require_memory(where,
                   static_cast<std::int64_t>(array.bytes.view.size() / sizeof(T) * sizeof(Value)));
    array.bytes = without_missing<T, Value>(array.bytes.view, missing);
    const ScalarType stored = array.type;
    array.type = is_wide ? ScalarType::kFloat64 : ScalarType::kFloat32;
    if (array.type != stored && counts.number)
      notes.push_back(fmt::format("{}: {} becomes {}: {} stands for missing samples", where,
                                  name_of(stored), name_of(array.type), *counts.number));
    if (counts.num_outside > 0)
      notes.push_back(fmt::format("{}: {} samples are outside of {}, and so missing", where,
                                  counts.num_outside, range));
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
  hide_missing_numbers(where, numbers, array, notes);
  const auto& factor = numbers.scale_factor;
  const auto& offset = numbers.add_offset;
  if (factor && std::isfinite(*factor) && *factor != 0) array.value_scale = *factor;
  if (offset && std::isfinite(*offset)) array.value_offset = *offset;
  array.unit = numbers.units;
}

CfAxis cf_axis_of(const CfAttributes& attributes) {
  return {cf_text(attributes, "axis"), cf_text(attributes, "standard_name"),
          cf_text(attributes, "units"), cf_text(attributes, "positive")};
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
      is_one_of(standard, {"depth", "height", "altitude", "model_level_number"}) ||
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
  if (dataset.num_steps < 2 || static_cast<std::int64_t>(times.size()) != dataset.num_steps) return;
  const bool do_rise = std::adjacent_find(times.begin(), times.end(), [](double a, double b) {
                         return !(a < b);
                       }) == times.end();
  if (!do_rise || !std::isfinite(times.front()) || !std::isfinite(times.back())) {
    dataset.notes.push_back(
        fmt::format("{}: the times do not rise: steps are counted instead", dataset.source));
    return;
  }
  dataset.times = std::move(times);
  const std::size_t since = units.find(" since ");
  dataset.time_unit = plain_time_unit(units.substr(0, since));
  if (since != std::string::npos)
    dataset.notes.push_back(fmt::format("{}: times are {}", dataset.source, units));
}

}  // namespace ovoid::io
