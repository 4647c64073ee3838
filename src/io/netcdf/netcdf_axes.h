// SPDX-License-Identifier: Apache-2.0
// What the dimensions of a netCDF variable are, and where its samples lie along them.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "io/core/byte_source.h"
#include "io/netcdf/netcdf_header.h"
#include "ovoid/dataset.h"

namespace ovoid::io {

// A letter (core/axis_order.h) for each dimension: by the CF attributes of the variable called like
// it, by its own name; the others are, from the fastest on, x, y, z, time and channels, as far as
// these are not taken; dimensions of one sample may be none.
std::string netcdf_axes(const NetcdfHeader& header, const NetcdfVariable& variable);

// Where samples lie in the world.
struct NetcdfPlaces {
  std::array<std::vector<double>, 3> along;  // x, y, z: as many as samples
  bool is_float64 = false;                   // as the file has them
  bool are_even = true;
};

// By the variables called like the axes' dimensions. Where the unit of z is none that x has, too,
// levels are put at equal distances, upwards as the file says, with a note. Empty, with a note,
// where x or y says nothing.
std::optional<NetcdfPlaces> netcdf_places(const ByteSource& source, const NetcdfHeader& header,
                                          const NetcdfVariable& variable, const std::string& axes,
                                          std::vector<std::string>& notes);

// Of one step the number, of several as many as there are; empty where the file names none.
std::vector<double> netcdf_times(const ByteSource& source, const NetcdfHeader& header,
                                 const NetcdfVariable& variable, const std::string& axes,
                                 std::string& units);

}  // namespace ovoid::io
