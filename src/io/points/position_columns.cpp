// SPDX-License-Identifier: Apache-2.0
#include "io/points/position_columns.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <span>
#include <string_view>
#include <utility>

#include "data/bookkeeping.h"
#include "io/core/text_scanner.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

using Names = std::vector<std::string>;
using Words = std::span<const std::string_view>;

// Beside the letter of an axis, or a number, in small letters without anything between.
constexpr std::array kPlaceWords = std::to_array<std::string_view>({"points",
                                                                    "coordinates",
                                                                    "positions",
                                                                    "position",
                                                                    "coords",
                                                                    "coordinate",
                                                                    "coord",
                                                                    "xyz",
                                                                    "pos",
                                                                    "point",
                                                                    "location",
                                                                    "loc",
                                                                    "particleposition",
                                                                    "centroid",
                                                                    "cellcentroid",
                                                                    "center",
                                                                    "centre",
                                                                    "cellcenter",
                                                                    "cellcentre",
                                                                    "node",
                                                                    "vertex"});
constexpr std::array kLengthUnits =
    std::to_array<std::string_view>({"m", "mm", "cm", "km", "um", "nm", "ft", "in", "px", "pix",
                                     "pixel", "pixels", "pc", "kpc", "mpc", "au"});
constexpr std::array kLongitudes =
    std::to_array<std::string_view>({"longitude", "lon", "lng", "long", "longitudes", "lons",
                                     "decimallongitude", "gpslongitude", "gpslon", "navlon"});
constexpr std::array kLatitudes = std::to_array<std::string_view>(
    {"latitude", "lat", "latitudes", "lats", "decimallatitude", "gpslatitude", "gpslat", "navlat"});
constexpr std::array kEastings =
    std::to_array<std::string_view>({"easting", "eastings", "utmeasting", "utmx", "utme"});
constexpr std::array kNorthings =
    std::to_array<std::string_view>({"northing", "northings", "utmnorthing", "utmy", "utmn"});
constexpr std::array kHeights =
    std::to_array<std::string_view>({"z", "altitude", "alt", "height", "elevation", "elev",
                                     "altitudes", "heights", "elevations", "gpsaltitude", "utmz"});
constexpr std::array kDepths = std::to_array<std::string_view>({"depth", "depths", "dep"});
constexpr std::array kDegrees = std::to_array<std::string_view>(
    {"degreesnorth", "degreeseast", "degreenorth", "degreeeast", "degrees", "degree", "degn",
     "dege", "degs", "deg", "dd", "wgs84"});
constexpr std::array kTimes =
    std::to_array<std::string_view>({"time", "date", "datetime", "timestamp", "year", "epoch"});

// In small letters, without unit and what stands between words.
std::string plain_name(const std::string& name) {
  std::string word = lower(split_unit(name).name);
  std::erase_if(word, [](char c) {
    return std::string_view(" _-:./[]()'\"").find(c) != std::string_view::npos;
  });
  return word;
}

std::optional<std::size_t> find_word(const Names& names, std::string_view word) {
  const auto found = std::find(names.begin(), names.end(), word);
  return found == names.end() ? std::nullopt
                              : std::optional(static_cast<std::size_t>(found - names.begin()));
}

// The first column called like one of the words, perhaps with a unit behind it ("depth_km").
std::optional<std::size_t> find_any(const Names& names, Words words, Words units) {
  for (const std::string_view word : words) {
    if (const auto found = find_word(names, word)) return found;
    for (const std::string_view unit : units)
      if (const auto found = find_word(names, fmt::format("{}{}", word, unit))) return found;
  }
  return std::nullopt;
}

// How positions were found; `says_so`: their names leave no doubt.
struct Found {
  PositionColumns positions;
  bool says_so = true;
};

template <typename NameOfAxis>
std::optional<Found> find_three(const Names& names, const NameOfAxis& name_of_axis) {
  Found found;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    found.positions.columns[axis] = find_word(names, name_of_axis(axis));
    if (!found.positions.columns[axis]) return std::nullopt;
  }
  return found;
}

char letter(std::size_t axis) { return "xyz"[axis]; }

// All three by a letter or number of the axis and the same word.
std::optional<Found> find_lettered(const Names& names) {
  const auto alone = [](std::size_t axis) { return std::string(1, letter(axis)); };
  if (auto found = find_three(names, alone)) return found;
  for (const std::string_view word : kPlaceWords) {
    const auto behind = [&](std::size_t axis) { return fmt::format("{}{}", word, letter(axis)); };
    if (auto found = find_three(names, behind)) return found;
    const auto before = [&](std::size_t axis) { return fmt::format("{}{}", letter(axis), word); };
    if (auto found = find_three(names, before)) return found;
    const auto number = [&](std::size_t axis) { return fmt::format("{}{}", word, axis); };
    if (auto found = find_three(names, number)) return found;
  }
  for (const std::string_view unit : kLengthUnits) {
    const auto of_unit = [&](std::size_t axis) { return fmt::format("{}{}", letter(axis), unit); };
    if (auto found = find_three(names, of_unit)) return found;
  }
  return std::nullopt;
}

// Two columns of a horizontal plane, and a height, a depth or neither.
std::optional<Found> find_horizontal(const Names& names, Words east, Words north, Words units) {
  const auto x = find_any(names, east, units), y = find_any(names, north, units);
  if (!x || !y) return std::nullopt;
  Found found{{{x, y, std::nullopt}, false, ""}, false};
  found.positions.columns[2] = find_any(names, kHeights, kLengthUnits);
  if (found.positions.columns[2]) return found;
  found.positions.columns[2] = find_any(names, kDepths, kLengthUnits);
  found.positions.is_depth = found.positions.columns[2].has_value();
  return found;
}

std::optional<Found> find_named(const std::vector<PointColumn>& columns) {
  Names names;
  names.reserve(columns.size());
  for (const PointColumn& column : columns) names.push_back(plain_name(column.name));
  if (auto found = find_lettered(names)) return found;
  static constexpr std::array<std::string_view, 1> kX{"x"}, kY{"y"};
  auto flat = find_horizontal(names, kX, kY, {});
  if (flat && flat->positions.columns[2]) return flat;
  if (auto found = find_horizontal(names, kLongitudes, kLatitudes, kDegrees)) return found;
  if (auto found = find_horizontal(names, kEastings, kNorthings, kLengthUnits)) return found;
  const auto p = [](std::size_t axis) { return fmt::format("p{}", letter(axis)); };
  if (auto found = find_three(names, p)) {
    found->says_so = false;
    return found;
  }
  return flat;
}

// Numbers of points and times are no places, unless there is nothing else.
std::optional<Found> find_first(const std::vector<PointColumn>& columns) {
  const auto is_place = [&](const PointColumn& column) {
    Dataset points;
    points.kind = DatasetKind::kParticles;
    DataArray array;
    array.name = split_unit(column.name).name;
    const std::string word = plain_name(column.name);
    return !data::is_bookkeeping(points, array) &&
           std::find(kTimes.begin(), kTimes.end(), word) == kTimes.end();
  };
  for (const bool are_all_places : {false, true}) {
    Found found{{}, false};
    std::size_t count = 0;
    for (std::size_t i = 0; i < columns.size() && count < 3; ++i) {
      if (columns[i].is_number && (are_all_places || is_place(columns[i])))
        found.positions.columns[count++] = i;
    }
    if (count == 3) return found;
  }
  return std::nullopt;
}

// "x is 'longitude', y is 'latitude', z is minus 'depth'"
std::string told(const std::vector<PointColumn>& columns, const PositionColumns& positions) {
  std::string text;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    text += fmt::format("{}{} is ", axis == 0 ? "" : ", ", letter(axis));
    if (const auto column = positions.columns[axis])
      text += fmt::format("{}'{}'", axis == 2 && positions.is_depth ? "minus " : "",
                          columns[*column].name);
    else
      text += "0, since no column is called z, depth, altitude or the like";
  }
  return text;
}

// A unit that one of the axes names is that of all of them.
void find_unit(const std::string& where, const std::vector<PointColumn>& columns,
               PositionColumns& positions, std::vector<std::string>& notes) {
  Names units;
  for (const auto& column : positions.columns)
    if (column) units.push_back(split_unit(columns[*column].name).unit);
  const auto named = std::find_if(units.begin(), units.end(),
                                  [](const std::string& unit) { return !unit.empty(); });
  if (named == units.end()) return;
  const auto is_other = [&](const std::string& unit) { return !unit.empty() && unit != *named; };
  if (std::none_of(units.begin(), units.end(), is_other)) {
    positions.unit = *named;
    return;
  }
  for (std::string& unit : units)
    if (unit.empty()) unit = "none";
  notes.push_back(
      fmt::format("{}: positions have several units ({}): their numbers are taken as "
                  "they are",
                  where, fmt::join(units, ", ")));
}

}  // namespace

bool has_position_names(const std::vector<PointColumn>& columns) {
  return find_named(columns).has_value();
}

PositionColumns find_position_columns(const std::string& where,
                                      const std::vector<PointColumn>& columns,
                                      std::vector<std::string>& notes) {
  const auto named = find_named(columns);
  const auto found = named ? named : find_first(columns);
  if (!found) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: {} columns, fewer than three of them numbers: expected positions "
                            "x, y, z",
                            where, columns.size()));
  }
  PositionColumns positions = found->positions;
  for (const auto& column : positions.columns) {
    if (column && !columns[*column].is_number) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: column '{}' of the positions holds no numbers", where,
                              columns[*column].name));
    }
  }
  const bool has_names = std::any_of(columns.begin(), columns.end(), [](const PointColumn& column) {
    return !column.name.empty();
  });
  if (named && !found->says_so) {
    notes.push_back(fmt::format("{}: positions: {}", where, told(columns, positions)));
  } else if (!named && has_names) {
    notes.push_back(fmt::format(
        "{}: no columns are called x, y, z: '{}', '{}' and '{}' are taken for the positions", where,
        columns[*positions.columns[0]].name, columns[*positions.columns[1]].name,
        columns[*positions.columns[2]].name));
  }
  find_unit(where, columns, positions, notes);
  return positions;
}

}  // namespace ovoid::io
