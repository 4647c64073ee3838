// SPDX-License-Identifier: Apache-2.0
// Where the samples of a Zarr array are in space and time.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "io/zarr/ome_images.h"
#include "io/zarr/zarr_array.h"
#include "ovoid/dataset.h"

namespace ovoid::io {

// By a level of an image: lattice.world_from_index, times and time_unit, with notes. Lengths are in
// the unit of x.
void place_ome_level(const OmeImage& image, const OmeLevel& level, Dataset& dataset);

// By the arrays of one axis that lie beside the array and are called like its axes, as xarray
// writes them (io/core/cf_conventions.h). `axes`: what the names stand for.
void place_zarr_array(const std::shared_ptr<const ZarrStore>& store, const ZarrNode& node,
                      const std::string& axes, Dataset& dataset);

// What CF's attributes say of the numbers: scale and offset, unit, and those that stand for missing
// samples, which become NaN.
void apply_cf_attributes(const ZarrNode& node, const std::string& where, DataArray& array,
                         std::vector<std::string>& notes);

}  // namespace ovoid::io
