// SPDX-License-Identifier: Apache-2.0
// What the CF conventions [CF] say of a variable: which numbers stand for missing samples, what the
// others stand for, which axis is which, and where samples lie along it. netCDF, HDF5 and Zarr
// share them.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "ovoid/dataset.h"

namespace ovoid::io {

// Samples of the array that are one of these numbers, as stored, become NaN; integers become
// float32, those of 4 and 8 bytes float64, with a note. Where there are none, or the samples stay
// in their file, nothing changes. `where` names the array. Throws Error(kOutOfMemory).
void hide_missing_numbers(const std::string& where, std::span<const double> numbers,
                          DataArray& array, std::vector<std::string>& notes);

// Attributes of an array's numbers, as far as it has them.
struct CfNumbers {
  std::vector<double> missing;  // _FillValue, missing_value
  std::optional<double> scale_factor, add_offset;
  std::string units;
};

// Scale, offset and unit of the array, and hide_missing_numbers(). A factor of 0, and numbers that
// are not finite, are passed over.
void apply_cf_numbers(const std::string& where, const CfNumbers& numbers, DataArray& array,
                      std::vector<std::string>& notes);

// Attributes of a coordinate variable; empty: not there.
struct CfAxis {
  std::string axis, standard_name, units, positive;
};

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

// The times of dataset's steps, if they are as many, finite, and rise; of "days since 1900-01-01"
// the unit is "d", and a note tells since when.
void set_cf_times(std::vector<double> times, const std::string& units, Dataset& dataset);

}  // namespace ovoid::io
