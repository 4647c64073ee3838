// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "ovoid/lattice.h"

namespace ovoid::io {

// Where the samples along one axis of a rectilinear grid lie.
struct AxisCoordinates {
  std::vector<double> values;  // at least one
  bool is_float32 = false;     // as the file stores them: they are rounded to that
};

// Largest distance of a coordinate from where equal spacing would put it, in spacings, beside the
// rounding of its own type.
inline constexpr double kMaxUnevenness = 1e-4;

// The lattice that a rectilinear grid with equal spacing is; empty if it is none. An axis of one
// sample gets the smallest spacing of the others, or 1. Throws Error(kFileFormat) if coordinates
// are not finite or all the same.
std::optional<LatticeGeometry> lattice_of_coordinates(const std::string& name,
                                                      const std::array<AxisCoordinates, 3>& axes);

}  // namespace ovoid::io
