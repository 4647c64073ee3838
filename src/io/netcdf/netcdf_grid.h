// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// A classic netCDF file that is no Exodus mesh.
bool is_netcdf_grid(const ByteSource& source, std::string_view start);

// Reads variables on a grid: that of options.array, or all if they are of one size.
// docs/formats.md, "netCDF", says how dimensions become axes, and where samples lie. Uneven places
// make a structured mesh. Planes are read as they are needed. Throws Error: kFileFormat,
// kUnsupported without a grid, kInvalidArgument that lists what can be chosen.
Dataset read_netcdf_grid(const ByteSource& source, const ReadOptions& options);

// Of a file of one step.
std::optional<double> time_of_netcdf(const ByteSource& source);

}  // namespace ovoid::io
