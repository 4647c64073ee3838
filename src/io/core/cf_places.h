// SPDX-License-Identifier: Apache-2.0
// What the dimensions of a variable are, and where its samples lie along them, by the CF
// conventions [CF]: the same for netCDF, Zarr and HDF5.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/core/cf_file.h"
#include "ovoid/dataset.h"

namespace ovoid::io {

// For each dimension of a variable, in its order, the variable that says where samples lie along
// it; null where there is none.
using CfCoordinates = std::vector<const CfVariable*>;

// Finds them in a description that outlives this.
class CfCoordinateFinder {
 public:
  explicit CfCoordinateFinder(const CfDescription& file);

  // Those called like the dimensions; else those of one dimension, this one, that are alone in
  // saying which axis they are: by attributes, by being named in `coordinates`, or by their own
  // name. Where dimensions have no names, those of the same group that are as long as they, and
  // called like axes: as many as there are, in the order time, z, y, x where several fit.
  CfCoordinates of(const CfVariable& variable) const;

 private:
  const CfVariable* along(std::size_t dimension, const std::vector<std::string>& listed) const;

  const CfDescription& file_;
  std::vector<std::vector<const CfVariable*>> along_;  // each dimension, of variables of one
  std::map<std::string, std::vector<const CfVariable*>, std::less<>> called_like_axes_;  // by group
};

// A letter (axis_order.h) for each dimension: by the CF attributes of its coordinate, by its name;
// the others are, from the fastest on, x, y, z, time and channels, as far as these are not taken;
// dimensions of one sample may be none.
std::string cf_axes(const CfDescription& file, const CfVariable& variable,
                    const CfCoordinates& coordinates);

// Those that coordinates or names tell alone; the others are kPassedAxis.
std::string cf_told_axes(const CfDescription& file, const CfVariable& variable,
                         const CfCoordinates& coordinates);

// Where samples lie in the world.
struct CfPlaces {
  std::array<std::vector<double>, 3> along;  // x, y, z: as many as samples
  bool is_float64 = false;                   // as the file has them
  bool are_even = true;
};

// By the coordinates. What says nothing along x or y alone lies at the other's mean distance. Where
// the unit of z is none that x has, too, levels are put at equal distances, upwards as the file
// says. Notes tell. Empty, with a note, where both x and y say nothing.
std::optional<CfPlaces> cf_places(const CfFile& file, const CfVariable& variable,
                                  const std::string& axes, const CfCoordinates& coordinates,
                                  std::vector<std::string>& notes);

// Of one step the number, of several as many as there are; empty where the file names none.
struct CfTimes {
  std::vector<double> times;
  std::string units;
};
CfTimes cf_times(const CfFile& file, const std::string& axes, const CfCoordinates& coordinates);

// The words of an attribute that lists variables.
std::vector<std::string> cf_words(const CfAttributes& attributes, std::string_view name);

}  // namespace ovoid::io
