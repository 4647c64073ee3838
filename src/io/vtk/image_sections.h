// SPDX-License-Identifier: Apache-2.0
// What both of VTK's formats of images ask of a lattice that is written.
#pragma once

#include <string>
#include <vector>

#include "ovoid/dataset.h"

namespace ovoid::io {

// Arrays of samples, or of cells.
struct ImageSection {
  std::vector<const DataArray*> arrays;  // in the dataset's order
  const DataArray* scalars = nullptr;    // what programs without a choice show; null: none
};

struct ImageSections {
  ImageSection of_points, of_cells;
};

// Throws Error(kUnsupported) for an axis too long for VTK, and for two arrays of one name in one
// section, of which VTK would read one.
ImageSections image_sections(const Dataset& dataset, const std::string& path);

}  // namespace ovoid::io
