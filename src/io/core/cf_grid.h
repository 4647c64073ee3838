// SPDX-License-Identifier: Apache-2.0
// Datasets of files of variables on named dimensions.
#pragma once

#include "io/core/cf_file.h"
#include "io/core/cf_places.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Does the file have a variable on a grid, or that of options.array?
bool has_cf_grid(const CfFile& file, const ReadOptions& options);

// Reads variables on a grid: that of options.array, or all if they are of one size.
// docs/formats.md, "netCDF", says how dimensions become axes, and where samples lie. Uneven places
// make a structured mesh. Chunks are read as they are needed. Throws Error: kFileFormat,
// kUnsupported without a grid, kInvalidArgument that lists what can be chosen.
Dataset read_cf_grid(const CfFile& file, const ReadOptions& options);

// The lattice of dataset lies at even places; at uneven ones its samples are the nodes of a mesh,
// with a note. Throws Error(kOutOfMemory), and what check_mesh() does.
void place_by_cf(const CfPlaces& places, Dataset& dataset);

}  // namespace ovoid::io
