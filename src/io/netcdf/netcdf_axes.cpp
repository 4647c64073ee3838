// SPDX-License-Identifier: Apache-2.0
#include "io/netcdf/netcdf_axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "io/core/axis_order.h"
#include "io/core/cf_conventions.h"
#include "io/core/length_units.h"
#include "io/core/samples.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kMostCoordinates = 1'000'000;  // along an axis, that are looked at

CfAxis cf_axis_of(const NetcdfVariable& coordinate) {
  return {coordinate.text("axis"), coordinate.text("standard_name"), coordinate.text("units"),
          coordinate.text("positive")};
}

// The variable called like the dimension of that letter; null if there is none.
const NetcdfVariable* coordinate_of(const NetcdfHeader& header, const NetcdfVariable& variable,
                                    const std::string& axes, char letter) {
  const auto place = axis_place(axes, letter);
  if (!place) return nullptr;
  const NetcdfVariable* const found =
      header.variable(header.dimensions[variable.dims[*place]].name);
  return found != nullptr && found->dims == std::vector{variable.dims[*place]} ? found : nullptr;
}

std::optional<char> letter_of(const NetcdfHeader& header, std::size_t dimension) {
  const std::string& name = header.dimensions[dimension].name;
  const NetcdfVariable* const coordinate = header.variable(name);
  if (coordinate != nullptr && coordinate->dims == std::vector{dimension})
    if (const auto letter = cf_axis(cf_axis_of(*coordinate))) return letter;
  return axis_called(name);
}

// Finite, and rising or falling.
bool are_places(const std::vector<double>& places) {
  if (places.empty()) return false;
  const double sign = places.back() < places.front() ? -1 : 1;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!std::isfinite(places[i])) return false;
    if (i > 0 && !(sign * places[i] > sign * places[i - 1])) return false;
  }
  return true;
}

double mean_distance(const std::vector<double>& places) {
  return places.size() < 2
             ? 0
             : std::abs(places.back() - places.front()) / static_cast<double>(places.size() - 1);
}

// How many of x's unit one of z's is; none if the two cannot be told from each other.
std::optional<double> factor_of(const NetcdfVariable* x, const NetcdfVariable* z) {
  const auto unit_of = [](const NetcdfVariable* coordinate) {
    return coordinate == nullptr ? std::string() : plain_unit(coordinate->text("units"));
  };
  const std::string ours = unit_of(x), theirs = unit_of(z);
  if (ours == theirs) return 1;
  const auto our_metres = metres_in(ours), their_metres = metres_in(theirs);
  if (!our_metres || !their_metres) return std::nullopt;
  return *their_metres / *our_metres;
}

}  // namespace

std::string netcdf_axes(const NetcdfHeader& header, const NetcdfVariable& variable) {
  std::string axes(variable.dims.size(), kPassedAxis);
  for (std::size_t a = 0; a < axes.size(); ++a) {
    const auto letter = letter_of(header, variable.dims[a]);
    if (letter && !axis_place(axes, *letter)) axes[a] = *letter;
  }
  const bool has_records = !axes.empty() && variable.has_records && axes[0] == kPassedAxis;
  if (has_records && !axis_place(axes, 't')) axes[0] = 't';
  for (std::size_t a = axes.size(); a-- > 0;) {
    // A plane's x and y may have one sample; other dimensions of one sample say nothing.
    const bool is_single = header.dimensions[variable.dims[a]].size == 1;
    for (const char letter : {'x', 'y', 'z', 't', 'c'}) {
      if (axes[a] != kPassedAxis || axis_place(axes, letter)) continue;
      if (!is_single || letter == 'x' || letter == 'y') axes[a] = letter;
      if (is_single) break;
    }
  }
  return axes;
}

std::optional<NetcdfPlaces> netcdf_places(const ByteSource& source, const NetcdfHeader& header,
                                          const NetcdfVariable& variable, const std::string& axes,
                                          std::vector<std::string>& notes) {
  NetcdfPlaces places;
  std::array<const NetcdfVariable*, 3> coordinates{};
  constexpr std::string_view kLetters = "xyz";
  for (std::size_t i = 0; i < 3; ++i) {
    coordinates[i] = coordinate_of(header, variable, axes, kLetters[i]);
    if (coordinates[i] == nullptr) continue;
    places.along[i] = netcdf_numbers(source, header, *coordinates[i], kMostCoordinates);
    if (!are_places(places.along[i])) places.along[i].clear();
    if (coordinates[i]->type == ScalarType::kFloat64) places.is_float64 = true;
  }
  auto& [x, y, z] = places.along;
  if (x.empty() || y.empty()) {
    notes.push_back(fmt::format(
        "{}: no variables called like the axes of '{}' say where samples lie along x and y: they "
        "lie at equal distances; --spacing says which",
        source.name(), variable.name));
    return std::nullopt;
  }
  const auto place_z = axis_place(axes, 'z');
  const std::int64_t num_levels = place_z ? header.shape(variable)[*place_z] : 1;
  const auto factor = factor_of(coordinates[0], coordinates[2]);
  const bool is_down = coordinates[2] != nullptr && counts_down(cf_axis_of(*coordinates[2]));
  if (!z.empty() && factor) {
    for (double& place : z) place *= is_down ? -*factor : *factor;
  } else if (num_levels == 1) {
    z.assign(1, 0);
  } else {
    const bool is_falling = !z.empty() && (z.back() < z.front()) != is_down;
    const double along_x = mean_distance(x), along_y = mean_distance(y);
    double step = along_x > 0 && along_y > 0 ? std::min(along_x, along_y) : along_x + along_y;
    if (!(step > 0)) step = 1;
    z.clear();
    for (std::int64_t i = 0; i < num_levels; ++i)
      z.push_back(static_cast<double>(is_falling ? -i : i) * step);
    const std::string unit = coordinates[2] == nullptr ? "" : coordinates[2]->text("units");
    notes.push_back(fmt::format("{}: levels lie {:.6g} apart{}: {}; --spacing A,B,C says another",
                                source.name(), step, is_falling ? ", downwards" : "",
                                unit.empty() ? "nothing says where"
                                             : fmt::format("'{}' is no unit beside '{}'", unit,
                                                           coordinates[0]->text("units"))));
  }
  for (const std::vector<double>& along : places.along)
    places.are_even = places.are_even && (along.size() < 2 || even_places(along));
  return places;
}

std::vector<double> netcdf_times(const ByteSource& source, const NetcdfHeader& header,
                                 const NetcdfVariable& variable, const std::string& axes,
                                 std::string& units) {
  const NetcdfVariable* const time = coordinate_of(header, variable, axes, 't');
  if (time == nullptr) return {};
  units = time->text("units");
  return netcdf_numbers(source, header, *time, kMostCoordinates);
}

}  // namespace ovoid::io
