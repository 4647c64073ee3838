// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stop_token>
#include <string>

#include "ovoid/dataset.h"

namespace ovoid::io {

// Writes a Cartesian lattice as legacy VTK structured points: all arrays of samples and of cells,
// binary, which is big endian; names and units encoded as VTK encodes them. Without VTK. Arrays
// that are scaled must have been made plain. Throws Error(kFileWrite); kUnsupported for axes that
// are turned or flipped, for an axis too long for VTK, for two arrays of one name, and for a name
// or unit that takes more than a word of the format.
void write_legacy_vtk(const Dataset& dataset, const std::string& path,
                      const std::stop_token& stop = {});

}  // namespace ovoid::io
