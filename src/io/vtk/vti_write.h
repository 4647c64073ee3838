// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stop_token>
#include <string>

#include "ovoid/dataset.h"

namespace ovoid::io {

// Writes a Cartesian lattice as a VTI file (VTK's XML image: all arrays of samples and of cells,
// appended, raw, in blocks of zlib data), without VTK. Names, units, values and the place read back
// to the bit; control characters in names and units become blanks. Arrays that are scaled must have
// been made plain. Throws Error(kFileWrite); kUnsupported for an axis too long for VTK, and for two
// arrays of one name, of which VTK would read one.
void write_vti(const Dataset& dataset, const std::string& path, const std::stop_token& stop = {});

}  // namespace ovoid::io
