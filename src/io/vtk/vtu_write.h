// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stop_token>
#include <string>

#include "ovoid/dataset.h"

namespace ovoid::io {

// Writes a mesh as a VTU file (VTK's XML, appended raw data in native byte order), without VTK.
// Structured cells become hexahedra; cells whose number of nodes is not their type's become convex
// point sets. Arrays that are scaled must have been made plain. Throws Error(kFileWrite);
// kInvalidArgument that names what contradicts itself: cells, nodes, an array's length.
void write_vtu(const Dataset& dataset, const std::string& path, const std::stop_token& stop = {});

}  // namespace ovoid::io
