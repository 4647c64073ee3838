// SPDX-License-Identifier: Apache-2.0
// What the CF conventions [CF] say of a variable: which numbers stand for missing samples, what the
// others stand for, which axis is which, and where samples lie along it. netCDF, HDF5 and Zarr
// share them.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "ovoid/dataset.h"

namespace ovoid::io {

// An attribute of an array: text, or numbers.
struct CfAttribute {
  std::string name;
  std::string text{};
  std::vector<double> numbers{};
  std::optional<ScalarType> type{};  // of the numbers, as the file has them
};
using CfAttributes = std::vector<CfAttribute>;

// Those that say anything here, for readers that ask for attributes by their names.
inline constexpr std::array kCfAttributes = {
    "axis",        "standard_name", "units",      "positive",      "bounds",      "climatology",
    "coordinates", "cell_measures", "_FillValue", "missing_value", "valid_range", "valid_min",
    "valid_max",   "scale_factor",  "add_offset", "_Unsigned"};

// Null: not there.
const CfAttribute* find_cf(const CfAttributes& attributes, std::string_view name);
// Without blanks around it; empty: not there.
std::string cf_text(const CfAttributes& attributes, std::string_view name);
// All numbers of an attribute, or the one that its text is; empty: none.
std::vector<double> cf_numbers_of(const CfAttributes& attributes, std::string_view name);
// The first of them.
std::optional<double> cf_number(const CfAttributes& attributes, std::string_view name);

// What attributes say of an array's numbers.
struct CfNumbers {
  std::vector<double> missing{};  // _FillValue, missing_value
  // valid_range, valid_min and valid_max, of the numbers as stored.
  double valid_min = -std::numeric_limits<double>::infinity();
  double valid_max = std::numeric_limits<double>::infinity();
  std::optional<double> scale_factor{}, add_offset{};
  std::string units{};
};

// What stands for samples that nobody has written, where no _FillValue says it.
enum class CfFill { kNone, kOfNetcdf };

// Samples are taken for numbers of `type`, which cf_type() tells. The netCDF library's own fill
// value is missing, too, where `fill` says so: bytes have none.
CfNumbers cf_numbers(const CfAttributes& attributes, ScalarType type, CfFill fill);

// Unsigned integers where the attribute _Unsigned says that signed ones stand for them.
ScalarType cf_type(const CfAttributes& attributes, ScalarType stored);

// Samples of the array that are one of numbers.missing, or outside of the valid range, become NaN;
// integers become float32, those of 4 and 8 bytes float64, with a note. Where there are none, or
// the samples stay in their file, nothing changes; a range that no sample lies in is passed over,
// with a note. Integers of 8 bytes are compared as they are drawn: as float64. `where` names the
// array. Throws Error(kOutOfMemory).
void hide_missing_numbers(const std::string& where, const CfNumbers& numbers, DataArray& array,
                          std::vector<std::string>& notes);

// Scale, offset and unit of the array, and hide_missing_numbers(). A factor of 0, and numbers that
// are not finite, are passed over.
void apply_cf_numbers(const std::string& where, const CfNumbers& numbers, DataArray& array,
                      std::vector<std::string>& notes);

// Attributes of a coordinate variable; empty: not there.
struct CfAxis {
  std::string axis, standard_name, units, positive;
};
CfAxis cf_axis_of(const CfAttributes& attributes);

// The letter (axis_order.h) of the axis that they name; none if they name none.
std::optional<char> cf_axis(const CfAxis& attributes);

// Does a coordinate count downwards: `positive` says so, or it is a pressure?
bool counts_down(const CfAxis& attributes);

// The first place and the distance, if there are at least two and all distances are the same to a
// thousandth.
std::optional<std::pair<double, double>> even_places(std::span<const double> places);

// The samples of dataset.lattice lie where coordinates along x, y and z say, if those of every axis
// longer than one sample are as many as its samples, and even. An axis of one sample gets the
// least spacing of the others. False, and nothing done, otherwise.
bool place_by_coordinates(const std::array<std::vector<double>, 3>& places, Dataset& dataset);

// The times of dataset's steps, if they are as many, finite, and rise, or a note tells that they do
// not; of "days since 1900-01-01" the unit is "d", and a note tells since when.
void set_cf_times(std::vector<double> times, const std::string& units, Dataset& dataset);

}  // namespace ovoid::io
