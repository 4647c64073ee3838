// SPDX-License-Identifier: Apache-2.0
// Where the samples of an image in Zarr are in space and time.
#pragma once

#include "io/zarr/ome_images.h"
#include "ovoid/dataset.h"

namespace ovoid::io {

// By a level of an image: lattice.world_from_index, times and time_unit, with notes. Lengths are in
// the unit of x.
void place_ome_level(const OmeImage& image, const OmeLevel& level, Dataset& dataset);

}  // namespace ovoid::io
